#include "slam/nn/kernels/instruction_set.hpp"

#include <algorithm>
#include <atomic>

#include "slam/base/error.hpp"

namespace imslam::nn {
namespace {

bool is_available(InstructionSet set) {
  if (set == InstructionSet::kSse2) return true;
  const bool avx2 = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  if (set == InstructionSet::kAvx2) return avx2;
  return avx2 && __builtin_cpu_supports("avx512f") != 0 &&
         __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
         __builtin_cpu_supports("avx512bw") != 0;
}

std::atomic<InstructionSet>& selection() {
  static std::atomic<InstructionSet> set{available_instruction_sets().back()};
  return set;
}

}  // namespace

const char* name(InstructionSet set) {
  constexpr const char* kNames[] = {"SSE2", "AVX2", "AVX-512"};
  return kNames[static_cast<int>(set)];
}

std::vector<InstructionSet> available_instruction_sets() {
  std::vector<InstructionSet> sets;
  for (const auto set : {InstructionSet::kSse2, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (is_available(set)) sets.push_back(set);
  }
  return sets;
}

InstructionSet selected_instruction_set() { return selection(); }

void select_instruction_set(InstructionSet set) {
  expects(is_available(set), "select_instruction_set: this machine lacks the instruction set");
  selection() = set;
}

namespace kernels {

const KernelTable& selected_kernels() {
  switch (selected_instruction_set()) {
    case InstructionSet::kAvx512:
      return *avx512_kernels();
    case InstructionSet::kAvx2:
      return *avx2_kernels();
    default:
      return *sse2_kernels();
  }
}

}  // namespace kernels
}  // namespace imslam::nn

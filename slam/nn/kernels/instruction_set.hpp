#pragma once

#include <vector>

#include "slam/nn/kernels/kernel_table.hpp"

namespace imslam::nn {

/// In rising order of speed. AVX2 includes FMA; AVX-512 means F, VL, DQ and BW.
enum class InstructionSet { kSse2, kAvx2, kAvx512 };

const char* name(InstructionSet set);

/// Those that this machine can execute, slowest first.
std::vector<InstructionSet> available_instruction_sets();

/// The fastest one unless another was selected.
InstructionSet selected_instruction_set();

/// For tests and benchmarks, between calls of kernels. ContractError if the machine lacks it.
void select_instruction_set(InstructionSet set);

namespace kernels {

const KernelTable& selected_kernels();

}  // namespace kernels
}  // namespace imslam::nn

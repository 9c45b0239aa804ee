#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/vo_net/match_fixture.hpp"

namespace {

std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* const memory =
      std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Every new of this executable is counted.
void* operator new(std::size_t size) { return counted(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  try {
    return counted(size, alignof(std::max_align_t));
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace imslam::vo {
namespace {

TEST(MatchAllocation, FramesAfterTheFirstAllocateNothing) {
  Random random(1);
  MatchNetwork<float> network(imslam::testing::tiny_match_network(), random);
  network.fold();
  nn::Tensor<float> image({1, 53, 70, 1});
  for (nn::Index i = 0; i < image.size(); ++i) {
    image[i] = static_cast<float>(random.uniform(0.0, 255.0));
  }
  const nn::Tensor<float> points =
      nn::cast<float>(imslam::testing::random_points(random, 100, 53, 70, 0.0));
  nn::Tape<float> tape(nn::Mode::kInference);
  long settled = 0;
  for (int frame = 0; frame < 5; ++frame) {
    if (frame == 2) settled = allocations;
    tape.reset();
    const FeaturePyramid f0 = network.encode(tape, tape.constant(image));
    const FeaturePyramid f1 = network.encode(tape, tape.constant(image));
    const nn::Var at = tape.constant(points);
    network.forward(tape, f0, f1, at, MatchKind::kFlow);
    network.forward(tape, f0, f1, at, MatchKind::kStereo);
  }
  EXPECT_EQ(allocations - settled, 0);
}

}  // namespace
}  // namespace imslam::vo

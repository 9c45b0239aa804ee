#include <gtest/gtest.h>

#include "tests/support/counted_memory.hpp"
#include "tests/vo_net/match_fixture.hpp"

namespace imslam::vo {
namespace {

using testing::counted_memory;

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
    if (frame == 2) settled = counted_memory().allocations;
    tape.reset();
    const FeaturePyramid f0 = network.encode(tape, tape.constant(image));
    const FeaturePyramid f1 = network.encode(tape, tape.constant(image));
    const nn::Var at = tape.constant(points);
    network.forward(tape, f0, f1, at, MatchKind::kFlow);
    network.forward(tape, f0, f1, at, MatchKind::kStereo);
  }
  EXPECT_EQ(counted_memory().allocations - settled, 0);
}

}  // namespace
}  // namespace imslam::vo

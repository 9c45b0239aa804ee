#include "tools/bench/matching/yardsticks.hpp"

#include <gtest/gtest.h>

#include "datasets/simulation/simulate.hpp"
#include "slam/base/error.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/test_data.hpp"
#include "tools/bench/matching/warp_check.hpp"

namespace imslam::bench {
namespace {

using imslam::testing::TempDir;
using imslam::testing::test_data;
using vo::MatchKind;

void expect_that_truth_explains_images(const std::vector<MatchScene>& scenes,
                                       MatchKind kind,
                                       double most_residual) {
  const WarpCheck check = check_by_warping(scenes, kind);
  EXPECT_GT(check.points, 1000U);
  EXPECT_TRUE(check.holds()) << check.truth << ' ' << check.one_pixel << ' ' << check.no_motion;
  EXPECT_LT(check.truth, most_residual);
}

TEST(Yardsticks, TartanAirIsReadByItsConventions) {
  IMSLAM_NEEDS(test_data() / "tartanair_p000_excerpt");
  const auto scenes = read_tartanair(test_data() / "tartanair_p000_excerpt", 2);
  ASSERT_EQ(scenes.size(), 2U);
  expect_that_truth_explains_images(scenes, MatchKind::kStereo, 1.0);
  expect_that_truth_explains_images(scenes, MatchKind::kFlow, 3.0);
}

TEST(Yardsticks, Kitti2012IsReadByItsConventions) {
  IMSLAM_NEEDS(test_data() / "kitti2012_stereo_excerpt");
  const auto scenes = read_kitti2012(test_data() / "kitti2012_stereo_excerpt", 2);
  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_FALSE(scenes[0].has_flow);
  expect_that_truth_explains_images(scenes, MatchKind::kStereo, 5.0);
}

TEST(Yardsticks, MiddleburyIsReadByItsConventions) {
  IMSLAM_NEEDS(test_data() / "middlebury_flow_excerpt");
  const auto scenes = read_middlebury(test_data() / "middlebury_flow_excerpt", 9);
  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_FALSE(scenes[0].has_stereo);
  expect_that_truth_explains_images(scenes, MatchKind::kFlow, 2.0);
}

TEST(Yardsticks, SimulatedTruthIsCarriedToTheRectifiedViews) {
  const TempDir folder;
  simulation::SimulationOptions options;
  options.textures = "procedural";
  options.duration_s = 0.5;
  options.rest_s = 0.0;
  options.frame_rate_hz = 10.0;
  options.truth_depth = options.truth_flow = true;
  options.camera.width = 320;
  options.camera.misalignment_deg = 1.0;
  simulation::simulate(options, folder.path() / "run");
  const auto scenes = read_simulated(folder.path() / "run", 2);
  ASSERT_EQ(scenes.size(), 2U);
  expect_that_truth_explains_images(scenes, MatchKind::kStereo, 3.0);
  expect_that_truth_explains_images(scenes, MatchKind::kFlow, 3.0);
}

TEST(Yardsticks, MissingDataIsNamed) {
  const TempDir folder;
  EXPECT_THROW(read_tartanair(folder.path(), 1), InputError);
  EXPECT_THROW(read_kitti2012(folder.path(), 1), InputError);
  EXPECT_THROW(read_middlebury(folder.path(), 1), InputError);
  EXPECT_THROW(read_simulated(folder.path(), 1), InputError);
}

TEST(Yardsticks, TheWarpCheckNoticesAWrongSign) {
  IMSLAM_NEEDS(test_data() / "middlebury_flow_excerpt");
  auto scenes = read_middlebury(test_data() / "middlebury_flow_excerpt", 1);
  for (float& u : scenes[0].views.flow_u) u = -u;
  EXPECT_FALSE(check_by_warping(scenes, MatchKind::kFlow).holds());
}

}  // namespace
}  // namespace imslam::bench

#include "vo_net/loop_closer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "tests/vo_net/synthetic_images.hpp"

namespace imslam::vo {
namespace {

using testing::PlaneWorld;
using testing::small_camera;
using testing::time_of_frame;

VoOptions small_vo() {
  VoOptions options;
  options.klt.max_points = 250;
  return options;
}

lie::SE3d pose(double x, double y, double z, double rx, double ry, double rz) {
  return {lie::SO3d::exp(Eigen::Vector3d(rx, ry, rz)), Eigen::Vector3d(x, y, z)};
}

/// What the front end sees of a frame by itself.
std::vector<StereoPoint> points_of(const StereoFrame& frame) {
  KltMatcher matcher(small_vo().klt, small_camera());
  return matcher.match(frame, lie::SE3d()).points;
}

Keyframe keyframe_of(const StereoFrame& frame, const lie::SE3d& T_map_left) {
  Keyframe keyframe;
  keyframe.time_ns = frame.time_ns;
  keyframe.T_map_left = T_map_left;
  keyframe.left = frame.left;
  keyframe.points = points_of(frame);
  keyframe.median_disparity = 9.0;
  return keyframe;
}

CurrentView view_of(const StereoFrame& frame) {
  CurrentView view;
  view.left.build(frame.left, small_vo().klt.levels, small_vo().klt.smoothing);
  view.right.build(frame.right, small_vo().klt.levels, small_vo().klt.smoothing);
  return view;
}

/// A prediction that is `off` from the truth and says so.
PredictedMotion predicted_from(const lie::SE3d& T_body0_body1,
                               const Eigen::Matrix<double, 6, 1>& off) {
  PredictedMotion predicted;
  predicted.T_body0_body1 = T_body0_body1 * lie::SE3d::exp(off);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Eigen::Vector3d::Constant(0.02), Eigen::Vector3d::Constant(0.01);
  predicted.covariance = sigma.cwiseAbs2().asDiagonal();
  return predicted;
}

lie::SE3d body_motion(const lie::SE3d& T_left0_left1) {
  const lie::SE3d& T_body_left = small_camera().T_body_left;
  return T_body_left * T_left0_left1 * T_body_left.inverse();
}

Eigen::Matrix<double, 6, 1> some_error() {
  Eigen::Matrix<double, 6, 1> off;
  off << 0.03, -0.02, 0.02, 0.012, -0.015, 0.01;
  return off;
}

/// Sideways, forwards, rolled about the optical axis.
lie::SE3d seen_again_from(int index) {
  if (index == 0) return pose(0.2, -0.1, 0.0, 0.02, 0.06, 0.0);
  if (index == 1) return pose(0.05, 0.05, 0.5, 0.0, -0.03, 0.05);
  return pose(-0.1, 0.1, -0.2, -0.03, 0.02, 0.5);
}

class LoopMatch : public ::testing::TestWithParam<int> {};

TEST_P(LoopMatch, GivesTheMotionToAPlaneSeenAgainFromAPoorPrediction) {
  const PlaneWorld world(4);
  const StereoCamera camera = small_camera();
  const lie::SE3d T_left0_left1 = seen_again_from(GetParam());
  const Keyframe keyframe =
      keyframe_of(world.draw(camera, lie::SE3d(), time_of_frame(0)), lie::SE3d());
  const CurrentView view = view_of(world.draw(camera, T_left0_left1, time_of_frame(99), 0.8));
  const KeyframeMatcher matcher(LoopOptions(), small_vo(), camera);
  const lie::SE3d truth = body_motion(T_left0_left1);
  const auto motion =
      matcher.match(keyframe, view, time_of_frame(99), predicted_from(truth, some_error()), 0.0);
  ASSERT_TRUE(motion.has_value());
  EXPECT_EQ(motion->time0_ns, time_of_frame(0));
  EXPECT_EQ(motion->time1_ns, time_of_frame(99));
  const Eigen::Matrix<double, 6, 1> error = (motion->T_body0_body1.inverse() * truth).log();
  EXPECT_LT(error.head<3>().norm(), 0.005);
  EXPECT_LT(error.tail<3>().norm(), 0.002);
  EXPECT_LT(error.dot(motion->covariance.ldlt().solve(error)), 25.0);
}

INSTANTIATE_TEST_SUITE_P(SidewaysForwardsRolled, LoopMatch, ::testing::Values(0, 1, 2));

TEST(KeyframeMatcher, FindsNothingInAnotherScene) {
  const StereoCamera camera = small_camera();
  const Keyframe keyframe =
      keyframe_of(PlaneWorld(4).draw(camera, lie::SE3d(), time_of_frame(0)), lie::SE3d());
  const KeyframeMatcher matcher(LoopOptions(), small_vo(), camera);
  for (const std::uint64_t seed : {5U, 6U, 7U}) {
    const CurrentView view = view_of(PlaneWorld(seed).draw(camera, lie::SE3d(), time_of_frame(99)));
    EXPECT_FALSE(matcher.match(keyframe, view, time_of_frame(99),
                               predicted_from(lie::SE3d(), some_error()), 0.0));
  }
}

TEST(KeyframeMatcher, DistrustsAMotionFarFromASurePrediction) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(4);
  const lie::SE3d T_left0_left1 = pose(0.1, 0.0, 0.0, 0.0, 0.02, 0.0);
  const Keyframe keyframe =
      keyframe_of(world.draw(camera, lie::SE3d(), time_of_frame(0)), lie::SE3d());
  const CurrentView view = view_of(world.draw(camera, T_left0_left1, time_of_frame(99)));
  PredictedMotion sure = predicted_from(body_motion(T_left0_left1), some_error());
  sure.covariance *= 1e-6;
  const KeyframeMatcher matcher(LoopOptions(), small_vo(), camera);
  EXPECT_FALSE(matcher.match(keyframe, view, time_of_frame(99), sure, 0.0));
}

TEST(KeyframeMap, StaysWithinItsBoundsAndKeepsTheOldestView) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(4);
  LoopOptions options;
  options.max_keyframes = 12;
  KeyframeMap map(options, camera);
  const Keyframe first =
      keyframe_of(world.draw(camera, lie::SE3d(), time_of_frame(0)), lie::SE3d());
  for (int i = 0; i < 200; ++i) {
    Keyframe keyframe = first;
    keyframe.time_ns = time_of_frame(100 * i);
    keyframe.T_map_left = pose(0.1 * i, 0.0, 0.0, 0.0, 0.0, 0.0);
    map.add(std::move(keyframe));
    ASSERT_LE(map.size(), 12U);
  }
  EXPECT_LT(static_cast<double>(map.bytes()), 12 * 0.2e6);
  const auto seen = map.candidates(lie::SE3d(), time_of_frame(100000));
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.front().keyframe->time_ns, time_of_frame(0));
}

TEST(KeyframeMap, KeepsFewerViewsWhereMemoryIsShort) {
  LoopOptions options;
  options.max_memory_mb = 1.0;
  EXPECT_LE(KeyframeMap(options, small_camera()).capacity(), 10U);
}

TEST(KeyframeMap, OffersNoViewYoungerThanTheGapNorOneThatLooksElsewhere) {
  const StereoCamera camera = small_camera();
  KeyframeMap map(LoopOptions(), camera);
  map.add(keyframe_of(PlaneWorld(4).draw(camera, lie::SE3d(), 0), lie::SE3d()));
  EXPECT_TRUE(map.candidates(lie::SE3d(), 1'000'000'000).empty());
  EXPECT_EQ(map.candidates(lie::SE3d(), 9'000'000'000).size(), 1U);
  EXPECT_TRUE(map.candidates(pose(0, 0, 0, 0, 1.6, 0), 9'000'000'000).empty());
}

TEST(KeyframeMap, FindsAViewByItsTime) {
  KeyframeMap map(LoopOptions(), small_camera());
  for (const std::int64_t time_ns : {5, 9}) {
    Keyframe keyframe;
    keyframe.time_ns = time_ns;
    map.add(std::move(keyframe));
  }
  ASSERT_NE(map.at(9), nullptr);
  EXPECT_EQ(map.at(9)->time_ns, 9);
  EXPECT_EQ(map.at(7), nullptr);
}

TEST(KeyframeMap, EachMoveMakesTheWayFromEveryViewLessSure) {
  KeyframeMap map(LoopOptions(), small_camera());
  for (const std::int64_t time_ns : {5, 9}) {
    Keyframe keyframe;
    keyframe.time_ns = time_ns;
    keyframe.covariance(5, 5) = time_ns == 5 ? 1e-4 : 0.0;  // of its heading
    map.add(std::move(keyframe));
  }
  Eigen::Matrix<double, 6, 6> step = Eigen::Matrix<double, 6, 6>::Zero();
  step.diagonal() << 1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6;
  map.move(pose(2.0, 0.0, 0.0, 0.0, 0.0, 0.0), step);
  EXPECT_EQ(map.at(9)->covariance, step);
  const auto& turned = map.at(5)->covariance;  // 2 m on, an error of the heading leads sideways
  EXPECT_NEAR(turned(0, 0), 1e-6, 1e-15);
  EXPECT_NEAR(turned(1, 1), 2e-6 + 4e-4, 1e-12);
  EXPECT_NEAR(turned(5, 5), 6e-6 + 1e-4, 1e-12);
  EXPECT_NEAR(std::abs(turned(1, 5)), 2e-4, 1e-12);
}

/// Sways in front of the plane for six seconds, with an odometry that drifts.
std::vector<RelativeMotion> loops_of_a_swaying_camera(double* end_error_rad) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(4);
  LoopCloser closer(LoopOptions(), small_vo(), camera);
  const auto pose_at = [](int i) {
    return pose(0.25 * std::sin(0.2 * i), 0.1 * std::sin(0.13 * i), 0.0, 0.0,
                0.08 * std::sin(0.15 * i), 0.0);
  };
  Eigen::Matrix<double, 6, 1> drift = Eigen::Matrix<double, 6, 1>::Zero();
  drift[4] = 5e-4;
  std::vector<RelativeMotion> all;
  for (int i = 0; i <= 80; ++i) {
    const StereoFrame frame = world.draw(camera, pose_at(i), 100'000'000LL * i);
    VoOutput seen;
    seen.points = points_of(frame);
    if (i > 0) {
      seen.motion.valid = true;
      seen.motion.time0_ns = 100'000'000LL * (i - 1);
      seen.motion.time1_ns = frame.time_ns;
      seen.motion.T_body0_body1 =
          body_motion(pose_at(i - 1).inverse() * pose_at(i)) * lie::SE3d::exp(drift);
      seen.motion.covariance = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
    }
    for (const RelativeMotion& motion : closer.process(frame, seen, 0.0)) all.push_back(motion);
  }
  const lie::SE3d truth = body_motion(pose_at(0).inverse() * pose_at(80));
  *end_error_rad = (closer.T_map_body().inverse() * truth).rotation().log().norm();
  return all;
}

TEST(LoopCloser, HoldsADriftingOdometryAndIsTheSameForAnyThreadCount) {
  double end_error_rad = 0.0;
  const auto loops = loops_of_a_swaying_camera(&end_error_rad);
  ASSERT_GE(loops.size(), 8U);
  EXPECT_LT(end_error_rad, 0.004);  // the odometry alone: 0.04
  set_thread_count(1);
  const auto again = loops_of_a_swaying_camera(&end_error_rad);
  set_thread_count(0);
  ASSERT_EQ(loops.size(), again.size());
  for (std::size_t i = 0; i < loops.size(); ++i) {
    EXPECT_EQ(loops[i].time0_ns, again[i].time0_ns);
    EXPECT_EQ(loops[i].T_body0_body1.matrix(), again[i].T_body0_body1.matrix());
    EXPECT_EQ(loops[i].covariance, again[i].covariance);
  }
}

/// Stands in front of the plane, turns by steps, and looks for old views every half second.
class TurningCamera {
 public:
  /// Turns to a yaw, 0 at first, by an odometry that states `sigma_rad` per axis and is wrong by
  /// `error_rad` about each. Returns what is recognised.
  std::vector<RelativeMotion> look(double yaw, double sigma_rad = 1e-4, double error_rad = 0.0) {
    const lie::SE3d T_world_left = pose(0.0, 0.0, 0.0, 0.0, yaw, 0.0);
    VoOutput seen;
    seen.motion.valid = true;
    seen.motion.time0_ns = frame_.time_ns;
    draw(T_world_left, frame_.time_ns + 500'000'000);
    seen.points = points_;
    seen.motion.time1_ns = frame_.time_ns;
    Eigen::Matrix<double, 6, 1> error;
    error << Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(error_rad);
    seen.motion.T_body0_body1 =
        body_motion(T_world_left_.inverse() * T_world_left) * lie::SE3d::exp(error);
    seen.motion.covariance.diagonal() << Eigen::Vector3d::Constant(1e-8),
        Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
    T_world_left_ = T_world_left;
    return closer_.process(frame_, seen, 0.0);
  }

  /// Ten seconds without a single motion.
  void lose_track() {
    for (int i = 0; i < 10; ++i) {
      frame_.time_ns += 1'000'000'000;
      closer_.process(frame_, VoOutput(), 0.0);
    }
  }

  std::int64_t now_ns() const { return frame_.time_ns; }

 private:
  static LoopOptions every_frame() {
    LoopOptions options;
    options.every = 1;
    return options;
  }

  void draw(const lie::SE3d& T_world_left, std::int64_t time_ns) {
    const bool same = frame_.complete() && T_world_left.matrix() == T_world_left_.matrix();
    if (!same) {
      frame_ = world_.draw(small_camera(), T_world_left, time_ns);
      points_ = points_of(frame_);
    }
    frame_.time_ns = time_ns;
  }

  PlaneWorld world_{4};
  LoopCloser closer_{every_frame(), small_vo(), small_camera()};
  StereoFrame frame_;
  std::vector<StereoPoint> points_;
  lie::SE3d T_world_left_;
};

/// That a motion is a turn by `yaw`, to the bounds of LoopMatch.
void expect_turn(const RelativeMotion& motion, double yaw) {
  const lie::SE3d truth = body_motion(pose(0.0, 0.0, 0.0, 0.0, yaw, 0.0));
  const Eigen::Matrix<double, 6, 1> error = (motion.T_body0_body1.inverse() * truth).log();
  EXPECT_LT(error.head<3>().norm(), 0.005);
  EXPECT_LT(error.tail<3>().norm(), 0.002);
}

TEST(LoopCloser, AfterALongCutViewsThatWereMadeSinceAreFoundAgain) {
  TurningCamera camera;
  camera.look(0.0);
  camera.lose_track();
  camera.look(0.8);
  const std::int64_t kept_ns = camera.now_ns();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(camera.look(0.8).empty()) << "younger than the gap";
  const auto loops = camera.look(0.83);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].time0_ns, kept_ns);
  expect_turn(loops[0], 0.03);
}

// The way between two views is as sure as the odometry's, however often one of them is seen.
TEST(LoopCloser, AViewSeenAgainAndAgainSaysNothingOfAnother) {
  TurningCamera camera;
  camera.look(0.0);
  const std::int64_t first_ns = camera.now_ns();
  camera.look(0.8, 0.02 / LoopOptions().drift_factor, 0.018);  // 0.031 rad: 1.6 sigma
  std::size_t again = 0;
  for (int i = 0; i < 30; ++i) again += camera.look(0.8).size();
  EXPECT_GE(again, 20U);
  const auto loops = camera.look(0.15);
  ASSERT_FALSE(loops.empty());
  EXPECT_EQ(loops[0].time0_ns, first_ns);
  expect_turn(loops[0], 0.15);
}

TEST(LoopOptions, NamesTheOptionThatIsOutOfBounds) {
  LoopOptions options;
  options.every = 0;
  try {
    options.validate();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("loops.every"), std::string::npos);
  }
}

}  // namespace
}  // namespace imslam::vo

#include "vo_net/klt_matcher.hpp"

#include <gtest/gtest.h>

#include <set>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "tests/vo_net/match_errors.hpp"
#include "vo_net/corner_detector.hpp"

namespace imslam::vo {
namespace {

using testing::noise_image;
using testing::PlaneWorld;
using testing::pose_of_frame;
using testing::quantile;
using testing::small_camera;
using testing::time_of_frame;
using testing::uniform_image;

KltOptions small_options() {
  KltOptions options;
  options.max_points = 250;
  return options;
}

testing::MatchErrors errors_of(const FrameMatch& match,
                               const PlaneWorld& world,
                               const StereoCamera& camera,
                               int frame0,
                               int frame1) {
  return testing::errors_of(match.correspondences, world, camera, pose_of_frame(frame0),
                            pose_of_frame(frame1));
}

TEST(KltMatcher, FollowsATexturedPlaneToAFewHundredthsOfAPixel) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(1);
  KltMatcher matcher(small_options(), camera);
  for (int i = 0; i < 4; ++i) {
    const MatchResult result =
        matcher.match(world.draw(camera, pose_of_frame(i), time_of_frame(i)), lie::SE3d());
    if (i == 0) {
      EXPECT_TRUE(result.previous.correspondences.empty());
      continue;
    }
    EXPECT_EQ(result.previous.time0_ns, time_of_frame(i - 1));
    ASSERT_GT(result.previous.correspondences.size(), 120U);
    const testing::MatchErrors errors = errors_of(result.previous, world, camera, i - 1, i);
    EXPECT_LT(quantile(errors.flow, 0.5), 0.04);
    EXPECT_LT(quantile(errors.flow, 0.95), 0.2);
    EXPECT_LT(quantile(errors.disparity, 0.5), 0.04);
    EXPECT_LT(quantile(errors.disparity, 0.95), 0.2);
  }
}

TEST(KltMatcher, DoesNotMindExposureSteps) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(2);
  KltMatcher matcher(small_options(), camera);
  const double gains[] = {1.0, 0.4, 0.9, 0.3};
  for (int i = 0; i < 4; ++i) {
    const MatchResult result = matcher.match(
        world.draw(camera, pose_of_frame(i), time_of_frame(i), gains[i]), lie::SE3d());
    if (i == 0) continue;
    ASSERT_GT(result.previous.correspondences.size(), 100U) << i;
    EXPECT_LT(quantile(errors_of(result.previous, world, camera, i - 1, i).flow, 0.5), 0.06);
  }
}

TEST(KltMatcher, GivesTheSameForAnyThreadCount) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(3);
  std::vector<Correspondences> results;
  const int before = thread_count();
  for (int threads : {1, 2}) {
    set_thread_count(threads);
    KltMatcher matcher(small_options(), camera);
    matcher.match(world.draw(camera, pose_of_frame(0), time_of_frame(0)), lie::SE3d());
    results.push_back(
        matcher.match(world.draw(camera, pose_of_frame(1), time_of_frame(1)), lie::SE3d())
            .previous.correspondences);
  }
  set_thread_count(before);
  ASSERT_EQ(results[0].size(), results[1].size());
  for (std::size_t k = 0; k < results[0].size(); ++k) {
    EXPECT_EQ(results[0][k].left1, results[1][k].left1);
    EXPECT_EQ(results[0][k].disparity1, results[1][k].disparity1);
    EXPECT_EQ(results[0][k].flow_information, results[1][k].flow_information);
    EXPECT_EQ(results[0][k].track_id, results[1][k].track_id);
  }
}

TEST(KltMatcher, RecoversFromAWrongPrediction) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(4);
  KltMatcher matcher(small_options(), camera);
  matcher.match(world.draw(camera, pose_of_frame(0), time_of_frame(0)), lie::SE3d());
  const lie::SE3d wrong(lie::SO3d::exp(Eigen::Vector3d(0.4, 0.4, 0.0)), Eigen::Vector3d::Zero());
  const MatchResult result =
      matcher.match(world.draw(camera, pose_of_frame(1), time_of_frame(1)), wrong);
  EXPECT_GT(result.previous.correspondences.size(), 120U);
}

TEST(KltMatcher, FindsNothingWithoutTexture) {
  const StereoCamera camera = small_camera();
  for (int value : {0, 128, 255}) {
    KltMatcher matcher(small_options(), camera);
    StereoFrame frame;
    frame.left = frame.right = uniform_image(camera, static_cast<std::uint8_t>(value));
    matcher.match(frame, lie::SE3d());
    const MatchResult result = matcher.match(frame, lie::SE3d());
    EXPECT_TRUE(result.previous.correspondences.empty());
    EXPECT_TRUE(result.points.empty());
  }
}

TEST(KltMatcher, FindsAlmostNothingInWhiteNoise) {
  const StereoCamera camera = small_camera();
  Random random(5);
  KltMatcher matcher(small_options(), camera);
  for (int i = 0; i < 3; ++i) {
    StereoFrame frame;
    frame.time_ns = time_of_frame(i);
    frame.left = noise_image(camera, random);
    frame.right = noise_image(camera, random);
    EXPECT_LT(matcher.match(frame, lie::SE3d()).previous.correspondences.size(), 5U);
  }
}

TEST(KltMatcher, DroppedTracksAreGone) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(6);
  KltMatcher matcher(small_options(), camera);
  matcher.match(world.draw(camera, pose_of_frame(0), time_of_frame(0)), lie::SE3d());
  const MatchResult first =
      matcher.match(world.draw(camera, pose_of_frame(1), time_of_frame(1)), lie::SE3d());
  std::set<std::int64_t> dropped;
  for (std::size_t k = 0; k < 20; ++k) dropped.insert(first.previous.correspondences[k].track_id);
  matcher.drop({dropped.begin(), dropped.end()});
  const MatchResult second =
      matcher.match(world.draw(camera, pose_of_frame(2), time_of_frame(2)), lie::SE3d());
  for (const Correspondence& c : second.previous.correspondences) {
    EXPECT_EQ(dropped.count(c.track_id), 0U);
  }
}

TEST(KltMatcher, KeyframeMatchesReachBackSeveralFrames) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(7);
  KltOptions options = small_options();
  options.keyframe_age = 4;
  KltMatcher matcher(options, camera);
  int seen = 0;
  for (int i = 0; i < 8; ++i) {
    const MatchResult result =
        matcher.match(world.draw(camera, pose_of_frame(i), time_of_frame(i)), lie::SE3d());
    for (const FrameMatch& earlier : result.earlier) {
      const int frame0 = static_cast<int>((earlier.time0_ns - time_of_frame(0)) / 50'000'000);
      EXPECT_GE(i - frame0, 2);
      EXPECT_LE(i - frame0, 4);
      ASSERT_GT(earlier.correspondences.size(), 60U);
      const testing::MatchErrors errors = errors_of(earlier, world, camera, frame0, i);
      EXPECT_LT(quantile(errors.flow, 0.5), 0.12) << frame0 << " " << i;
      ++seen;
    }
  }
  EXPECT_GE(seen, 4);
}

TEST(KltMatcher, NeedsBothImages) {
  const StereoCamera camera = small_camera();
  KltMatcher matcher(small_options(), camera);
  StereoFrame frame;
  frame.left = uniform_image(camera, 10);
  EXPECT_THROW(matcher.match(frame, lie::SE3d()), ContractError);
}

TEST(KltOptions, RefusesAnEvenWindow) {
  KltOptions options;
  options.window = 14;
  EXPECT_THROW(options.validate(), InputError);
}

TEST(CornerDetector, GivesOnePointPerFreeCell) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(8);
  ImagePyramid image;
  image.build(world.draw(camera, lie::SE3d(), 0).left, 3, 0.0);
  CornerOptions options;
  options.max_points = 100;
  const double side = cell_side(camera.width, camera.height, options.max_points);
  const auto cell_of = [&](const Eigen::Vector2d& p) {
    return std::pair(static_cast<int>(p.x() / side), static_cast<int>(p.y() / side));
  };
  const std::vector<Eigen::Vector2d> all = detect_corners(image, {}, options);
  EXPECT_GT(all.size(), 60U);
  std::set<std::pair<int, int>> cells;
  for (const Eigen::Vector2d& p : all) {
    EXPECT_TRUE(cells.insert(cell_of(p)).second);
    EXPECT_GE(p.minCoeff(), options.margin);
  }
  const std::vector<Eigen::Vector2d> taken(all.begin(), all.begin() + 30);
  EXPECT_EQ(detect_corners(image, taken, options).size(), all.size() - 30);
  EXPECT_TRUE(detect_corners(image, all, options).empty());
}

}  // namespace
}  // namespace imslam::vo

#include "vo_net/learned_matcher.hpp"

#include <gtest/gtest.h>

#include <set>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "tests/vo_net/match_errors.hpp"
#include "tests/vo_net/match_training.hpp"

namespace imslam::vo {
namespace {

using testing::PlaneWorld;
using testing::pose_of_frame;
using testing::quantile;
using testing::small_camera;
using testing::time_of_frame;
using testing::uniform_image;

/// Half confident of everything: what it does not see is the matcher's to notice.
std::shared_ptr<MatchNetwork<float>> untrained_network() {
  Random random(3);
  auto network = std::make_shared<MatchNetwork<float>>(testing::tiny_match_network(), random);
  network->fold();
  return network;
}

std::shared_ptr<MatchNetwork<float>> trained_network() {
  static const auto network =
      std::make_shared<MatchNetwork<float>>(testing::trained_match_network());
  return network;
}

constexpr double kSurest = 1.0 / (3.0 * 0.05 * 0.05);  // [1/px^2] e^kLogSigmaFloor is 0.05

LearnedMatcherOptions small_options() {
  LearnedMatcherOptions options;
  options.max_points = 250;
  options.max_polish_sigma = 3.0;  // a barely trained network doubts itself
  options.min_confidence = 0.3;
  return options;
}

LearnedMatcher trained_matcher(const LearnedMatcherOptions& options = small_options()) {
  return LearnedMatcher(options, small_camera(), trained_network());
}
LearnedMatcher untrained_matcher() {
  return LearnedMatcher(small_options(), small_camera(), untrained_network());
}

StereoFrame frame_of(const PlaneWorld& world, int index) {
  return world.draw(small_camera(), pose_of_frame(index), time_of_frame(index));
}

/// Those that Lucas-Kanade found: the network alone is never that sure (kLogSigmaFloor).
Correspondences polished(const FrameMatch& match) {
  Correspondences result;
  for (const Correspondence& c : match.correspondences) {
    if (c.flow_information(0, 0) > kSurest && c.disparity0_information > kSurest &&
        c.disparity1_information > kSurest) {
      result.push_back(c);
    }
  }
  return result;
}

void expect_same(const Correspondences& a, const Correspondences& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].left0, b[k].left0);
    EXPECT_EQ(a[k].left1, b[k].left1);
    EXPECT_EQ(a[k].disparity0, b[k].disparity0);
    EXPECT_EQ(a[k].disparity1, b[k].disparity1);
    EXPECT_EQ(a[k].flow_information, b[k].flow_information);
    EXPECT_EQ(a[k].weight, b[k].weight);
  }
}

TEST(LearnedMatcher, PolishingFindsThePlaneFromTheNetworksAnswers) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(1);
  LearnedMatcher matcher = trained_matcher();
  EXPECT_TRUE(matcher.match(frame_of(world, 0), lie::SE3d()).previous.correspondences.empty());
  for (int i = 1; i < 4; ++i) {
    const MatchResult result = matcher.match(frame_of(world, i), lie::SE3d());
    EXPECT_EQ(result.previous.time0_ns, time_of_frame(i - 1));
    EXPECT_GE(result.points.size(), result.previous.correspondences.size());
    const Correspondences sure = polished(result.previous);
    ASSERT_GT(sure.size(), 60U);
    const testing::MatchErrors errors =
        errors_of(sure, world, camera, pose_of_frame(i - 1), pose_of_frame(i));
    EXPECT_LT(quantile(errors.flow, 0.5), 0.05);
    EXPECT_LT(quantile(errors.flow, 0.9), 0.3);
    EXPECT_LT(quantile(errors.disparity, 0.5), 0.05);
  }
}

TEST(LearnedMatcher, WithoutPolishingTheNetworksOwnWordIsPassedOn) {
  const PlaneWorld world(1);
  LearnedMatcherOptions options = small_options();
  options.polish = false;
  LearnedMatcher matcher = trained_matcher(options);
  matcher.match(frame_of(world, 0), lie::SE3d());
  const MatchResult result = matcher.match(frame_of(world, 1), lie::SE3d());
  ASSERT_GT(result.previous.correspondences.size(), 60U);
  for (const Correspondence& c : result.previous.correspondences) {
    EXPECT_LT(c.flow_information(0, 0), kSurest);
    EXPECT_LT(c.disparity1_information, kSurest);
    EXPECT_GT(c.flow_information.determinant(), 0.0);
    EXPECT_GE(c.weight, options.min_confidence);
    EXPECT_LE(c.weight, 1.0);
  }
}

TEST(LearnedMatcher, SearchesWhereTheMotionIsExpected) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(2);
  const lie::SE3d T_left0_left1(lie::SO3d::exp(Eigen::Vector3d(0.0, 0.22, 0.0)),
                                Eigen::Vector3d::Zero());  // 53 px; the network reaches 40
  const lie::SE3d T_body0_body1 = camera.T_body_left * T_left0_left1 * camera.T_body_left.inverse();
  LearnedMatcher matcher = trained_matcher();
  matcher.match(world.draw(camera, lie::SE3d(), 0), lie::SE3d());
  const MatchResult result =
      matcher.match(world.draw(camera, T_left0_left1, 50'000'000), T_body0_body1);
  const Correspondences sure = polished(result.previous);
  ASSERT_GT(sure.size(), 40U);
  EXPECT_LT(quantile(errors_of(sure, world, camera, lie::SE3d(), T_left0_left1).flow, 0.5), 0.3);
}

TEST(LearnedMatcher, FindsNothingWithoutTexture) {
  const StereoCamera camera = small_camera();
  for (int value : {0, 128, 255}) {
    LearnedMatcher matcher = untrained_matcher();
    StereoFrame frame;
    frame.left = frame.right = uniform_image(camera, static_cast<std::uint8_t>(value));
    matcher.match(frame, lie::SE3d());
    const MatchResult result = matcher.match(frame, lie::SE3d());
    EXPECT_TRUE(result.previous.correspondences.empty());
    EXPECT_TRUE(result.points.empty());
  }
}

TEST(LearnedMatcher, FindsNothingInABlackFrameAfterAGoodOne) {
  const PlaneWorld world(3);
  LearnedMatcher matcher = untrained_matcher();
  matcher.match(frame_of(world, 0), lie::SE3d());
  StereoFrame black = frame_of(world, 1);
  black.left = uniform_image(small_camera(), 0);
  EXPECT_TRUE(matcher.match(black, lie::SE3d()).previous.correspondences.empty());
  matcher.forget_newest();
  EXPECT_FALSE(matcher.match(frame_of(world, 2), lie::SE3d()).previous.correspondences.empty());
}

TEST(LearnedMatcher, AnIdenticalFrameHasNotMoved) {
  const PlaneWorld world(4);
  LearnedMatcher matcher = trained_matcher();
  matcher.match(frame_of(world, 0), lie::SE3d());
  const Correspondences sure = polished(matcher.match(frame_of(world, 0), lie::SE3d()).previous);
  ASSERT_GT(sure.size(), 60U);
  for (const Correspondence& c : sure) EXPECT_LT((c.left1 - c.left0).norm(), 0.02);
}

TEST(LearnedMatcher, AForgottenFrameLeavesNoTrace) {
  const PlaneWorld world(5);
  LearnedMatcher matcher = untrained_matcher();
  LearnedMatcher undisturbed = untrained_matcher();
  matcher.match(frame_of(world, 0), lie::SE3d());
  undisturbed.match(frame_of(world, 0), lie::SE3d());
  matcher.match(frame_of(world, 7), lie::SE3d());
  matcher.forget_newest();
  const FrameMatch expected = undisturbed.match(frame_of(world, 1), lie::SE3d()).previous;
  const FrameMatch actual = matcher.match(frame_of(world, 1), lie::SE3d()).previous;
  EXPECT_EQ(actual.time0_ns, time_of_frame(0));
  ASSERT_FALSE(expected.correspondences.empty());
  expect_same(actual.correspondences, expected.correspondences);
}

TEST(LearnedMatcher, GivesTheSameForAnyThreadCount) {
  const PlaneWorld world(6);
  std::vector<Correspondences> results;
  const int before = thread_count();
  for (int threads : {1, 2}) {
    set_thread_count(threads);
    LearnedMatcher matcher = untrained_matcher();
    matcher.match(frame_of(world, 0), lie::SE3d());
    results.push_back(matcher.match(frame_of(world, 1), lie::SE3d()).previous.correspondences);
  }
  set_thread_count(before);
  ASSERT_FALSE(results[0].empty());
  expect_same(results[0], results[1]);
}

TEST(LearnedMatcher, DroppedTracksAreGoneAndAResetForgetsAll) {
  const PlaneWorld world(7);
  LearnedMatcher matcher = untrained_matcher();
  matcher.match(frame_of(world, 0), lie::SE3d());
  const MatchResult first = matcher.match(frame_of(world, 1), lie::SE3d());
  std::set<std::int64_t> dropped;
  for (std::size_t k = 0; k < 20; ++k) {
    dropped.insert(first.previous.correspondences.at(k).track_id);
  }
  matcher.drop({dropped.begin(), dropped.end()});
  const MatchResult second = matcher.match(frame_of(world, 2), lie::SE3d());
  for (const Correspondence& c : second.previous.correspondences) {
    EXPECT_EQ(dropped.count(c.track_id), 0U);
  }
  matcher.reset();
  EXPECT_TRUE(matcher.match(frame_of(world, 3), lie::SE3d()).previous.correspondences.empty());
}

TEST(LearnedMatcher, WideImagesAreHalvedForTheNetworkOnly) {
  StereoCamera camera = small_camera();
  camera.width = 641;
  camera.height = 483;  // neither divides by the cells of the network, nor by 2
  camera.fx = camera.fy = 480.0;
  camera.cx = 318.0;
  camera.cy = 243.0;
  const PlaneWorld world(8);
  LearnedMatcherOptions options = small_options();
  options.max_width = 400;
  options.polish = false;
  LearnedMatcher unpolished(options, camera, trained_network());
  unpolished.match(world.draw(camera, pose_of_frame(0), 0), lie::SE3d());
  const MatchResult coarse =
      unpolished.match(world.draw(camera, pose_of_frame(1), 50'000'000), lie::SE3d());
  const testing::MatchErrors errors =
      errors_of(coarse.previous.correspondences, world, camera, pose_of_frame(0), pose_of_frame(1));
  ASSERT_GT(errors.flow.size(), 60U);
  EXPECT_LT(quantile(errors.flow, 0.5), 4.0);  // px of the full image: two of the network's
}

TEST(LearnedMatcher, NeedsBothImages) {
  LearnedMatcher matcher = untrained_matcher();
  StereoFrame frame;
  frame.left = uniform_image(small_camera(), 10);
  EXPECT_THROW(matcher.match(frame, lie::SE3d()), ContractError);
  EXPECT_THROW(matcher.forget_newest(), ContractError);
}

TEST(LearnedMatcherOptions, RefusesWhatMakesNoSense) {
  LearnedMatcherOptions options;
  options.polish_window = 14;
  EXPECT_THROW(options.validate(), InputError);
  options = {};
  options.min_confidence = 1.0;
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::vo

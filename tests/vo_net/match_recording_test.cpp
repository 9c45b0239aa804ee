#include "vo_net/match_recording.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "tests/vo_net/synthetic_images.hpp"
#include "vo_net/visual_odometry.hpp"

namespace imslam::vo {
namespace {

using testing::PlaneWorld;
using testing::pose_of_frame;
using testing::small_camera;
using testing::time_of_frame;
using testing::uniform_image;

constexpr int kFrames = 6;

/// The drive through a plane world; frame `black` sees nothing.
StereoFrame frame_of(const PlaneWorld& world, int i, int black) {
  const StereoCamera camera = small_camera();
  StereoFrame frame = world.draw(camera, pose_of_frame(i), time_of_frame(i));
  if (i == black) frame.left = frame.right = uniform_image(camera, 0);
  return frame;
}

std::vector<VoOutput> drive(std::unique_ptr<Matcher> matcher, int black) {
  const PlaneWorld world(11);
  VisualOdometry odometry(VoOptions(), small_camera(), std::move(matcher));
  std::vector<VoOutput> seen;
  for (int i = 0; i < kFrames; ++i) seen.push_back(odometry.process(frame_of(world, i, black)));
  return seen;
}

std::shared_ptr<MatchRecording> record(int black, std::vector<VoOutput>& seen) {
  auto recording = std::make_shared<MatchRecording>();
  seen = drive(std::make_unique<RecordingMatcher>(
                   std::make_unique<KltMatcher>(KltOptions(), small_camera()), recording),
               black);
  return recording;
}

void expect_same_motions(const std::vector<VoOutput>& a, const std::vector<VoOutput>& b) {
  for (int i = 0; i < kFrames; ++i) {
    const auto& x = a[static_cast<std::size_t>(i)];
    const auto& y = b[static_cast<std::size_t>(i)];
    EXPECT_EQ(x.motion.valid, y.motion.valid) << i;
    EXPECT_EQ(x.motion.time0_ns, y.motion.time0_ns) << i;
    EXPECT_EQ(x.motion.T_body0_body1.matrix(), y.motion.T_body0_body1.matrix()) << i;
    EXPECT_EQ(x.skip_motions.size(), y.skip_motions.size()) << i;
    EXPECT_EQ(x.points.size(), y.points.size()) << i;
  }
}

TEST(MatchRecording, GivesTheSameMotionsAgain) {
  std::vector<VoOutput> first;
  const auto recording = record(-1, first);
  EXPECT_EQ(recording->size(), static_cast<std::size_t>(kFrames));
  ASSERT_TRUE(first.back().motion.valid);
  expect_same_motions(first, drive(std::make_unique<ReplayingMatcher>(recording), -1));
}

TEST(MatchRecording, GivesThemAgainAcrossAFrameThatWasForgotten) {
  std::vector<VoOutput> first;
  const auto recording = record(3, first);
  ASSERT_FALSE(first[3].motion.valid);
  ASSERT_EQ(first[4].motion.time0_ns, time_of_frame(2));
  expect_same_motions(first, drive(std::make_unique<ReplayingMatcher>(recording), 3));
}

TEST(MatchRecording, DoesNotMatchWithAFrameThatNoLongerCounts) {
  std::vector<VoOutput> first;
  const auto recording = record(-1, first);
  const PlaneWorld world(11);
  ReplayingMatcher replay(recording);
  replay.match(frame_of(world, 0, -1), {});
  EXPECT_FALSE(replay.match(frame_of(world, 1, -1), {}).previous.correspondences.empty());
  replay.forget_newest();
  const MatchResult next = replay.match(frame_of(world, 2, -1), {});
  EXPECT_TRUE(next.previous.correspondences.empty());
  EXPECT_FALSE(next.points.empty());
}

TEST(MatchRecording, RefusesAFrameThatItNeverSaw) {
  const PlaneWorld world(11);
  ReplayingMatcher replay(std::make_shared<MatchRecording>());
  EXPECT_THROW(replay.match(frame_of(world, 0, -1), {}), ContractError);
}

}  // namespace
}  // namespace imslam::vo

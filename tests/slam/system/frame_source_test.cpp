#include "slam/system/frame_source.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "datasets/open_sequence.hpp"
#include "slam/system/run_sequence.hpp"
#include "tests/support/test_data.hpp"

namespace imslam::system {
namespace {

/// Counts how often images are decoded.
class CountingSequence final : public datasets::Sequence {
 public:
  explicit CountingSequence(std::unique_ptr<datasets::Sequence> inner) : inner_(std::move(inner)) {}

  std::string format() const override { return inner_->format(); }
  std::string name() const override { return inner_->name(); }
  const std::filesystem::path& root() const override { return inner_->root(); }
  const StereoCamera& camera() const override { return inner_->camera(); }
  std::size_t frame_count() const override { return inner_->frame_count(); }
  std::int64_t frame_time_ns(std::size_t index) const override {
    return inner_->frame_time_ns(index);
  }
  StereoFrame read_frame(std::size_t index) override {
    ++reads;
    StereoFrame frame = inner_->read_frame(index);
    if (index == kDamaged) frame.right = {};
    return frame;
  }
  const std::optional<datasets::ImuData>& imu() const override { return inner_->imu(); }
  const std::optional<PosePath>& truth() const override { return inner_->truth(); }
  const lie::SE3d& T_body_truth() const override { return inner_->T_body_truth(); }
  std::vector<std::filesystem::path> input_files() const override { return inner_->input_files(); }

  static constexpr std::size_t kDamaged = 17;
  int reads = 0;

 private:
  std::unique_ptr<datasets::Sequence> inner_;
};

constexpr std::size_t kFrames = 80;

std::filesystem::path shaken_vehicle() { return testing::test_data() / "euroc_mh01_excerpt"; }

SlamOptions with_loops() {
  SlamOptions options;
  options.loops.min_gap_s = 1.0;
  return options;
}

SlamResult run(CountingSequence& sequence, const Networks& networks) {
  RunRequest request;
  request.last_frame = kFrames;
  request.networks = &networks;
  return run_sequence(sequence, with_loops(), request).result;
}

/// The same with all images at hand.
SlamResult run_with_images(CountingSequence& sequence, const Networks& networks) {
  SlamSystem slam(with_loops(), sequence.camera(), sequence.imu()->noise, &networks);
  std::size_t next = 0;
  const auto& samples = sequence.imu()->samples;
  for (std::size_t i = 0; i < kFrames; ++i) {
    const StereoFrame frame = sequence.read_frame(i);
    for (; next < samples.size() && samples[next].time_ns <= frame.time_ns + 150'000'000; ++next) {
      const bool earlier = samples[next].time_ns < sequence.frame_time_ns(0) - 150'000'000;
      earlier ? slam.add_earlier_imu(samples[next]) : slam.add_imu(samples[next]);
    }
    slam.process(frame);
  }
  return slam.finish();
}

TEST(FrameSource, ARunOnARecordingIsTheSameWithoutImagesAndDecodesFew) {
  IMSLAM_NEEDS(shaken_vehicle());
  CountingSequence sequence(datasets::open_sequence(shaken_vehicle()));
  Networks recording;
  recording.record_matches = std::make_shared<vo::MatchRecording>();
  const SlamResult first = run(sequence, recording);
  EXPECT_EQ(sequence.reads, static_cast<int>(kFrames));
  EXPECT_GT(first.counters.loop_edges, 0U);

  Networks replay;
  replay.matches = recording.record_matches;
  const SlamResult with_images = run_with_images(sequence, replay);
  sequence.reads = 0;
  const SlamResult without = run(sequence, replay);
  EXPECT_GT(sequence.reads, 0);  // loops look at pixels
  EXPECT_LE(sequence.reads, static_cast<int>(kFrames) / 5);

  EXPECT_EQ(without.counters.frames_missing, 1U);
  EXPECT_EQ(without.counters.loop_edges, with_images.counters.loop_edges);
  EXPECT_GT(without.counters.loop_edges, 0U);
  ASSERT_EQ(without.graph.size(), with_images.graph.size());
  for (std::size_t i = 0; i < without.graph.size(); ++i) {
    EXPECT_EQ(without.graph.poses[i].matrix(), with_images.graph.poses[i].matrix()) << i;
  }
}

TEST(FrameSource, WithoutARecordingEveryFrameIsDecoded) {
  IMSLAM_NEEDS(shaken_vehicle());
  CountingSequence sequence(datasets::open_sequence(shaken_vehicle()));
  FrameSource frames(sequence, 2, 5, nullptr);
  for (std::size_t index = 2; index < 5; ++index) {
    const auto frame = frames.next();
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(frame->index, index);
    EXPECT_FALSE(frame->unread);
    EXPECT_FALSE(frame->left.empty());
  }
  EXPECT_FALSE(frames.next().has_value());
}

}  // namespace
}  // namespace imslam::system

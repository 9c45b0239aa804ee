#include "slam/system/run_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/base/time.hpp"
#include "slam/system/frame_source.hpp"
#include "slam/system/front_end.hpp"
#include "slam/system/known_device.hpp"
#include "slam/system/slam_system.hpp"

namespace imslam::system {
namespace {

/// Samples may be needed a little after a frame's stamp: the clocks are up to 0.1 s apart, beyond
/// what is known of them.
constexpr double kImuLookAhead_s = 0.15;

struct FrameRange {
  std::size_t first = 0;
  std::size_t last = 0;
};

FrameRange frame_range(const datasets::Sequence& sequence, const RunRequest& request) {
  const std::size_t count = sequence.frame_count();
  const std::size_t last = request.last_frame == 0 ? count : request.last_frame;
  if (request.first_frame + 2 > last || last > count) {
    throw InputError(
        fmt::format("--frames {}:{}: the sequence has {} frames, from 0; at least two are "
                    "needed",
                    request.first_frame, last, count),
        count < 2 ? ExitCode::kData : ExitCode::kUsage);
  }
  return {request.first_frame, last};
}

/// Hands over samples as time goes on. Those long before the first frame only tell about the
/// sensor.
class ImuFeed {
 public:
  /// `samples` null: there is no IMU.
  ImuFeed(const std::vector<ImuSample>* samples,
          std::int64_t start_ns,
          double time_offset_s,
          SlamSystem& slam)
      : samples_(samples),
        look_ahead_ns_(to_nanoseconds(kImuLookAhead_s + std::abs(time_offset_s))) {
    if (samples_ == nullptr) return;
    for (; next_ < samples_->size() && (*samples_)[next_].time_ns < start_ns - look_ahead_ns_;
         ++next_) {
      slam.add_earlier_imu((*samples_)[next_]);
    }
  }

  void advance(std::int64_t frame_time_ns, SlamSystem& slam) {
    if (samples_ == nullptr) return;
    for (; next_ < samples_->size() && (*samples_)[next_].time_ns <= frame_time_ns + look_ahead_ns_;
         ++next_) {
      slam.add_imu((*samples_)[next_]);
    }
  }

 private:
  const std::vector<ImuSample>* samples_ = nullptr;
  std::int64_t look_ahead_ns_;
  std::size_t next_ = 0;
};

void expect_imu_covers_frames(const datasets::Sequence& sequence, const FrameRange& range) {
  const auto& samples = sequence.imu()->samples;
  const std::int64_t first_ns = sequence.frame_time_ns(range.first);
  const std::int64_t last_ns = sequence.frame_time_ns(range.last - 1);
  expects(!samples.empty(), "Sequence::imu: samples, or none at all");
  if (samples.front().time_ns <= last_ns && samples.back().time_ns >= first_ns) return;
  throw InputError(
      fmt::format("{}: the IMU ({} to {} ns) covers none of the frames ({} to {} ns); write all "
                  "stamps in nanoseconds of one clock, or leave the IMU out with --imu off",
                  sequence.root().string(), samples.front().time_ns, samples.back().time_ns,
                  first_ns, last_ns));
}

/// A poor truth costs the figures, never the run.
std::optional<RunEvaluation> evaluate_if_possible(const datasets::Sequence& sequence,
                                                  SlamResult& result) {
  if (!sequence.truth()) return std::nullopt;
  try {
    return evaluate_run(result, *sequence.truth(), sequence.T_body_truth());
  } catch (const InputError& error) {
    result.warnings.push_back(fmt::format("no evaluation: {}", error.what()));
    return std::nullopt;
  }
}

bool uses_imu(const datasets::Sequence& sequence, const SlamOptions& options) {
  if (options.system.imu == "off") return false;
  if (!sequence.imu()) log::warn("{} has no IMU data: vision only", sequence.name());
  return sequence.imu().has_value();
}

}  // namespace

void check_request(const datasets::Sequence& sequence,
                   const SlamOptions& options,
                   const RunRequest& request) {
  const FrameRange range = frame_range(sequence, request);
  if (options.system.imu != "off" && sequence.imu()) expect_imu_covers_frames(sequence, range);
  make_front_end(options, sequence.camera(), request.networks);  // throws without weights
}

RunOutcome run_sequence(datasets::Sequence& sequence,
                        const SlamOptions& options,
                        const RunRequest& request) {
  check_request(sequence, options, request);
  const FrameRange range = frame_range(sequence, request);
  const bool inertial = uses_imu(sequence, options);
  std::optional<ImuNoise> noise;
  if (inertial) noise = sequence.imu()->noise;

  const auto start = std::chrono::steady_clock::now();
  std::string why_not;
  const DeviceCalibration device =
      request.device ? *request.device : known_device(options, sequence, why_not);
  FrameSource frames(sequence, range.first, range.last,
                     request.networks ? request.networks->matches.get() : nullptr);
  SlamSystem slam(options, sequence.camera(), noise, request.networks, device, frames.loader());
  slam.observe(request.observe);
  slam.observe_window(request.observe_window);
  ImuFeed imu(inertial ? &sequence.imu()->samples : nullptr, sequence.frame_time_ns(range.first),
              options.system.time_offset_s, slam);
  RunOutcome outcome;
  std::size_t done = 0;
  while (const auto frame = frames.next()) {
    imu.advance(frame->time_ns, slam);
    slam.process(*frame);
    ++done;
    if (request.keep_going && !request.keep_going(done, range.last - range.first)) {
      outcome.stopped = true;
      break;
    }
  }
  outcome.result = slam.finish();
  if (outcome.stopped && done < range.last - range.first) {
    outcome.result.warnings.push_back(
        fmt::format("stopped after {} of {} frames: everything here is about these", done,
                    range.last - range.first));
  }
  if (!why_not.empty()) outcome.result.warnings.push_back(std::move(why_not));
  outcome.result.device = device;
  if (inertial) outcome.result.counters.imu_dropped += sequence.imu()->dropped;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  outcome.summary = {sequence.name(), sequence.format(), elapsed.count()};
  outcome.summary.stopped = outcome.stopped;
  outcome.evaluation = evaluate_if_possible(sequence, outcome.result);
  return outcome;
}

}  // namespace imslam::system

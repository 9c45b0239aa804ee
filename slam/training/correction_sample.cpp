#include "slam/training/correction_sample.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "imu_net/imu_features.hpp"
#include "slam/base/time.hpp"

namespace imslam::training {
namespace {

constexpr std::int64_t kFirstWindow_ns = 1'000'000'000;  // by then the network has seen something

std::size_t state_at(const InertialLog& log, std::int64_t time_ns) {
  const auto found = std::lower_bound(
      log.truth.begin(), log.truth.end(), time_ns,
      [](const InertialLog::TrueState& state, std::int64_t time) { return state.time_ns < time; });
  return static_cast<std::size_t>(found - log.truth.begin());
}

std::vector<ImuMotion> draw_windows(const InertialLog& log,
                                    const WindowDraw& draw,
                                    Random& random) {
  std::vector<ImuMotion> windows;
  if (log.samples.empty() || log.truth.empty()) return windows;
  const std::int64_t first_ns =
      std::max(log.truth.front().time_ns, log.samples.front().time_ns + kFirstWindow_ns);
  const double span_s = to_seconds(log.truth.back().time_ns - first_ns);
  for (int i = 0; i < draw.count; ++i) {
    const double length_s = draw.least_s * std::pow(draw.most_s / draw.least_s, random.uniform());
    const double place = random.uniform();
    if (length_s > span_s) continue;
    const std::int64_t start_ns = first_ns + to_nanoseconds(place * (span_s - length_s));
    const std::size_t first = state_at(log, start_ns);
    const std::size_t last = state_at(log, start_ns + to_nanoseconds(length_s));
    if (last >= log.truth.size() || last <= first || jumps_between(log, first, last)) continue;
    windows.push_back(true_window(log, first, last).motion);
  }
  return windows;
}

}  // namespace

void make_correction_sample(InertialLog log,
                            const WindowDraw& draw,
                            Random random,
                            CorrectionSample& sample) {
  sample.log = std::move(log);
  sample.frames.clear();
  sample.task.frame_times.clear();
  imu::FeatureExtractor extractor(sample.log.noise);
  for (const ImuSample& reading : sample.log.samples) {
    for (const imu::ImuFrame& frame : extractor.add(reading)) {
      sample.frames.push_back(frame);
      sample.task.frame_times.push_back(frame.time_ns);
    }
  }
  sample.task.samples = &sample.log.samples;
  sample.task.noise = sample.log.noise;
  sample.task.windows = draw_windows(sample.log, draw, random);
}

InertialLog cropped(const InertialLog& log, double start_s, double length_s) {
  InertialLog part = log;
  if (log.truth.empty()) return part;
  const std::int64_t start_ns = log.truth.front().time_ns + to_nanoseconds(start_s);
  const std::int64_t end_ns = start_ns + to_nanoseconds(length_s);
  const auto outside = [&](const auto& item) {
    return item.time_ns < start_ns || item.time_ns > end_ns;
  };
  part.samples.erase(std::remove_if(part.samples.begin(), part.samples.end(), outside),
                     part.samples.end());
  const auto before = static_cast<std::size_t>(
      std::find_if_not(part.truth.begin(), part.truth.end(),
                       [&](const auto& state) { return state.time_ns < start_ns; }) -
      part.truth.begin());
  part.truth.erase(std::remove_if(part.truth.begin(), part.truth.end(), outside), part.truth.end());
  part.truth_jumps.clear();
  for (const std::size_t jump : log.truth_jumps) {
    if (jump > before && jump - before < part.truth.size())
      part.truth_jumps.push_back(jump - before);
  }
  return part;
}

}  // namespace imslam::training

#include "datasets/check_imu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/imu_csv.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

constexpr double kGravity = 9.81;       // [m/s^2]
constexpr double kBridgedGap_s = 0.05;  // preintegration interpolates up to here
constexpr double kUnbridgedGap_s = 0.5;
constexpr std::size_t kListedGaps = 5;

constexpr double kImpossible = 10.0;  ///< times the sensor's range

/// Samples of one kind.
struct Outliers {
  std::size_t count = 0;
  std::int64_t first_ns = 0;

  void add(const ImuSample& sample) {
    if (count++ == 0) first_ns = sample.time_ns;
  }
};

struct Steps {
  double median_s = 0.0;
  double largest_s = 0.0;
  std::size_t irregular = 0;  ///< more than 50 % off the median
};

Steps steps_of(const std::vector<std::int64_t>& times) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  Steps result;
  if (steps.empty()) return result;
  std::vector<std::int64_t> sorted = steps;
  std::sort(sorted.begin(), sorted.end());
  const std::int64_t median = sorted[sorted.size() / 2];
  result.median_s = to_seconds(median);
  result.largest_s = to_seconds(sorted.back());
  result.irregular = static_cast<std::size_t>(
      std::count_if(steps.begin(), steps.end(),
                    [median](std::int64_t step) { return std::abs(step - median) * 2 > median; }));
  return result;
}

std::vector<std::int64_t> frame_times(const Sequence& sequence) {
  std::vector<std::int64_t> times;
  for (std::size_t i = 0; i < sequence.frame_count(); ++i) {
    times.push_back(sequence.frame_time_ns(i));
  }
  return times;
}

std::vector<std::int64_t> sample_times(const ImuData& imu) {
  std::vector<std::int64_t> times;
  for (const ImuSample& sample : imu.samples) times.push_back(sample.time_ns);
  return times;
}

/// Where the sample with this stamp stands; 0: the file is none of lines, or moves its stamps.
std::size_t line_of_sample(const std::string& file, std::int64_t time_ns) {
  if (file.empty()) return 0;
  CsvReader csv = open_imu_csv(LineReader(file));
  for (;;) {
    try {
      if (!csv.next()) return 0;
      const ImuRow row = imu_row(csv);
      if (row.sample.time_ns == time_ns) return row.line;
    } catch (const InputError&) {
      continue;  // a finding of the line by line check
    }
  }
}

void check_frames(const std::vector<std::int64_t>& times, Findings& findings) {
  if (times.size() < 2) {
    findings.fail(ExitCode::kData, fmt::format("{} stereo frame only", times.size()),
                  "record a sequence: motion needs at least two frames");
    return;
  }
  const Steps steps = steps_of(times);
  findings.info(fmt::format("{} stereo frames in {:.2f} s, {:.2f} Hz", times.size(),
                            to_seconds(times.back() - times.front()), 1.0 / steps.median_s));
  std::size_t gaps = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double step_s = to_seconds(times[i] - times[i - 1]);
    if (step_s < 1.5 * steps.median_s || ++gaps > kListedGaps) continue;
    const std::string what = fmt::format("gap of {:.0f} ms between frames {} and {} (at {} ns)",
                                         step_s * 1e3, i - 1, i, times[i - 1]);
    if (step_s < kUnbridgedGap_s) {
      findings.info(what);
    } else {
      findings.warn(what, "the IMU has to bridge it; accuracy suffers");
    }
  }
  if (gaps > kListedGaps) findings.info(fmt::format("{} more gaps", gaps - kListedGaps));
}

/// Stamps of two sensors that do not meet: another unit, another clock, or another recording.
void check_overlap(const std::vector<std::int64_t>& frames,
                   const std::vector<std::int64_t>& samples,
                   Findings& findings) {
  if (frames.empty() || samples.empty()) return;
  const auto covered =
      static_cast<std::size_t>(std::count_if(frames.begin(), frames.end(), [&](std::int64_t t) {
        return t >= samples.front() && t <= samples.back();
      }));
  if (covered == frames.size()) return;
  if (covered > 0) {
    findings.warn(fmt::format("the IMU covers {} of {} frames", covered, frames.size()),
                  "the others are estimated from images alone");
    return;
  }
  std::string what = fmt::format("the IMU (from {} ns) covers none of the frames (from {} ns)",
                                 samples.front(), frames.front());
  std::string remedy = "check that both are stamped by one clock";
  const double ratio = static_cast<double>(frames.front()) / static_cast<double>(samples.front());
  for (const double factor : {1e3, 1e6, 1e9}) {
    for (const double f : {factor, 1.0 / factor}) {
      if (std::abs(ratio / f - 1.0) < 0.01) {
        what += fmt::format("; their stamps differ by a factor of {:g}", f);
        remedy = "write all stamps in nanoseconds";
      }
    }
  }
  const double hours = to_seconds(frames.front() - samples.front()) / 3600.0;
  if (std::abs(hours) < 26.0 && std::abs(hours - std::round(hours)) < 0.05 &&
      std::abs(hours) > 0.5) {
    remedy = fmt::format("the clocks differ by {:.0f} h: a time zone? {}", hours, remedy);
  }
  findings.fail(ExitCode::kData, what, remedy);
}

void check_truth(const PosePath& truth,
                 const std::vector<std::int64_t>& frames,
                 Findings& findings) {
  findings.info(
      fmt::format(
          "truth with {} poses of the {}", truth.size(),
          truth.frame.empty() ? "body" : truth.frame + (truth.frame == "left" ? " camera" : "")),
      truth.source);
  if (!truth.has_stamps() || frames.empty() || truth.size() == 0) return;
  const auto [first, last] = std::minmax_element(truth.stamps_s.begin(), truth.stamps_s.end());
  const auto covered = static_cast<std::size_t>(
      std::count_if(frames.begin(), frames.end(), [first = *first, last = *last](std::int64_t t) {
        return to_seconds(t) >= first - 0.05 && to_seconds(t) <= last + 0.05;
      }));
  if (covered < frames.size()) {
    findings.warn(
        fmt::format("the truth covers {} of {} frames", covered, frames.size()),
        covered == 0 ? "check that it belongs to this recording" : "only these are evaluated",
        truth.source);
  }
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Whether one axis never changes while the sensor as a whole does: a dead channel.
void check_frozen_axes(const ImuData& imu, const std::string& file, Findings& findings) {
  if (imu.samples.size() < 100) return;
  const char* const names[] = {"w_x", "w_y", "w_z", "a_x", "a_y", "a_z"};
  const auto value = [](const ImuSample& sample, int axis) {
    return axis < 3 ? sample.angular_velocity[axis] : sample.linear_acceleration[axis - 3];
  };
  for (int axis = 0; axis < 6; ++axis) {
    const double first = value(imu.samples.front(), axis);
    const bool frozen =
        std::all_of(imu.samples.begin(), imu.samples.end(),
                    [&](const ImuSample& sample) { return value(sample, axis) == first; });
    if (frozen) {
      findings.warn(fmt::format("{} is {} in every sample", names[axis], first),
                    "a dead channel or a wrong column?", file);
    }
  }
}

}  // namespace

void check_samples(const ImuData& imu, const std::string& file, Findings& findings) {
  const auto times = sample_times(imu);
  if (times.size() < 2) {
    findings.fail(ExitCode::kData, fmt::format("{} IMU sample only", times.size()),
                  "record the IMU with the cameras, or remove its file", file);
    return;
  }
  const Steps steps = steps_of(times);
  const double rate_hz = 1.0 / steps.median_s;
  findings.info(
      fmt::format("{} IMU samples in {:.2f} s, {:.1f} Hz; {} irregular steps, the longest "
                  "{:.1f} ms",
                  times.size(), to_seconds(times.back() - times.front()), rate_hz, steps.irregular,
                  steps.largest_s * 1e3),
      file);
  if (rate_hz < 50.0) {
    findings.warn(fmt::format("IMU rate of {:.1f} Hz", rate_hz),
                  "50 Hz and more are needed to integrate motion well", file);
  }
  std::size_t gaps = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double step_s = to_seconds(times[i] - times[i - 1]);
    if (step_s <= kBridgedGap_s || ++gaps > kListedGaps) continue;
    findings.warn(fmt::format("IMU gap of {:.0f} ms (at {} ns)", step_s * 1e3, times[i - 1]),
                  "the motion in it is uncertain; check the recorder for lost packets", file,
                  line_of_sample(file, times[i - 1]));
  }
  if (gaps > kListedGaps) {
    findings.warn(fmt::format("{} more IMU gaps", gaps - kListedGaps), "see the first ones", file);
  }
}

void check_timing(const Sequence& sequence, const std::string& imu_file, Findings& findings) {
  const auto frames = frame_times(sequence);
  check_frames(frames, findings);
  if (sequence.imu()) {
    check_samples(*sequence.imu(), imu_file, findings);
    check_overlap(frames, sample_times(*sequence.imu()), findings);
  } else {
    findings.info("no IMU: motion is estimated from images alone");
  }
  if (sequence.truth()) {
    check_truth(*sequence.truth(), frames, findings);
  } else {
    findings.info("no ground truth: a run will report no errors");
  }
}

void check_imu_values(const ImuData& imu, const std::string& file, Findings& findings) {
  if (imu.samples.size() < 2) return;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::vector<double> accelerations;
  std::vector<double> rates;
  Outliers saturated, impossible;
  for (const ImuSample& sample : imu.samples) {
    const double share_of_range =
        std::max(sample.linear_acceleration.cwiseAbs().maxCoeff() / imu.noise.accel_range,
                 sample.angular_velocity.cwiseAbs().maxCoeff() / imu.noise.gyro_range);
    if (share_of_range > kImpossible) {
      impossible.add(sample);
      continue;
    }
    if (share_of_range >= 1.0) saturated.add(sample);
    mean += sample.linear_acceleration;
    accelerations.push_back(sample.linear_acceleration.norm());
    rates.push_back(sample.angular_velocity.norm());
  }
  if (impossible.count > 0) {
    findings.warn(fmt::format("{} samples hold impossible values, far beyond the sensor's range",
                              impossible.count),
                  "they are treated as saturated; check the recorder", file,
                  line_of_sample(file, impossible.first_ns));
  }
  if (accelerations.empty()) return;
  mean /= static_cast<double>(accelerations.size());
  const double gravity = median(accelerations);
  findings.info(fmt::format("gravity: median specific force {:.3f} m/s^2, norm of the mean {:.3f}; "
                            "median rate {:.3f} rad/s",
                            gravity, mean.norm(), median(rates)),
                file);
  if (gravity > 0.5 && gravity < 2.0) {
    findings.fail(
        ExitCode::kData,
        fmt::format("median specific force is {:.3f}: the accelerometer seems to be in g", gravity),
        "multiply the accelerations by 9.80665 to get m/s^2", file);
  } else if (gravity < 0.5) {
    findings.fail(ExitCode::kData,
                  fmt::format("median specific force is {:.3g} m/s^2: gravity is missing", gravity),
                  "write the specific force as measured (9.81 upwards at rest)", file);
  } else if (std::abs(gravity - kGravity) > 1.5) {
    findings.warn(
        fmt::format("median specific force is {:.2f} m/s^2, not {:.2f}", gravity, kGravity),
        "check the accelerometer's unit and scale", file);
  }
  if (median(rates) > 4.0) {
    findings.warn(fmt::format("median rate of rotation is {:.1f} rad/s", median(rates)),
                  "is the gyro in degrees per second? Radians are expected", file);
  }
  if (saturated.count > 0) {
    findings.warn(fmt::format("{} samples reach the range of the sensor", saturated.count),
                  "their intervals are trusted less", file,
                  line_of_sample(file, saturated.first_ns));
  }
  check_frozen_axes(imu, file, findings);
}

}  // namespace imslam::datasets

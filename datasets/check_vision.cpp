#include "datasets/check_vision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "datasets/judge_calibration.hpp"
#include "datasets/recording.hpp"

namespace imslam::datasets {
namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr double kClearDisparity = 1.0;  // [px] beyond noise
constexpr double kRectified = 3.0;       // [px] rows of a pair that belongs together
constexpr std::size_t kMinMatches = 60;

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> magnitudes(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return values;
}

/// How the stereo matches of some frames lie.
struct MatchStatistics {
  double row_difference = 0.0;  ///< [px] median magnitude
  std::size_t positive = 0;     ///< clear disparities of either sign
  std::size_t negative = 0;

  bool enough() const { return positive + negative >= kMinMatches; }
  bool in_order() const { return row_difference < kRectified && positive > 2 * negative; }
  bool reversed() const { return row_difference < kRectified && negative > 2 * positive; }
};

/// Of the first `frames` complete frames that `read` gives.
template <typename Read>
MatchStatistics match_statistics(const Read& read, std::size_t count, std::size_t frames) {
  MatchStatistics statistics;
  std::vector<double> rows;
  const std::size_t end = std::min(count, 5 * frames);  // some may be damaged
  for (std::size_t i = 0, seen = 0; i < end && seen < frames; ++i) {
    const StereoFrame frame = read(i);
    if (!frame.complete()) continue;
    ++seen;
    const StereoMatches matches = match_stereo(frame.left, frame.right);
    for (std::size_t k = 0; k < matches.left.size(); ++k) {
      const Eigen::Vector2d difference = matches.left[k] - matches.right[k];
      rows.push_back(std::abs(difference.y()));
      statistics.positive += difference.x() > kClearDisparity ? 1 : 0;
      statistics.negative += difference.x() < -kClearDisparity ? 1 : 0;
    }
  }
  statistics.row_difference = median_of(rows);
  return statistics;
}

void check_rows(const VisualProbe& probe, Findings& findings) {
  const std::vector<double>& rows = probe.row_differences();
  if (rows.size() < kMinMatches) return;
  const double bias = median_of(rows);
  const double spread = median_of(magnitudes(rows));
  findings.info(
      fmt::format("stereo: median disparity {:.1f} px; rows of matches differ by {:.2f} px "
                  "(median), {:+.2f} px on average",
                  median_of(probe.disparities()), spread, bias));
  if (spread > 3.0) {
    findings.fail(
        ExitCode::kCalibration,
        fmt::format("rows of stereo matches differ by {:.1f} px: the pair is not rectified",
                    spread),
        "check intrinsics, distortion and extrinsics of both cameras");
  } else if (spread > 0.8) {
    findings.warn(fmt::format("rows of stereo matches differ by {:.2f} px", spread),
                  "below 0.5 px is usual: calibrate the pair again");
  }
}

}  // namespace

std::optional<Finding> check_stereo_order(Sequence& sequence, std::size_t frames) {
  const std::size_t count = sequence.frame_count();
  const auto given =
      match_statistics([&](std::size_t i) { return sequence.read_frame(i); }, count, frames);
  if (!given.enough() || given.in_order()) return std::nullopt;
  // Raw images that are rectified with each other's maps can have any disparity: only the other
  // order tells.
  bool fits_exchanged = false;
  if (auto* recorded = dynamic_cast<ExchangeableSequence*>(&sequence)) {
    const auto other = match_statistics(
        [&](std::size_t i) { return recorded->read_exchanged_frame(i); }, count, frames);
    fits_exchanged = other.enough() && other.in_order();
  }
  if (!fits_exchanged && !given.reversed()) return std::nullopt;
  return Finding{
      Severity::kError,
      "",
      0,
      fmt::format("left and right are exchanged: rows of stereo matches differ by {:.1f} "
                  "px with {:.0f} % of the disparities positive{}",
                  given.row_difference,
                  100.0 * static_cast<double>(given.positive) /
                      static_cast<double>(given.positive + given.negative),
                  fits_exchanged ? "; exchanged, they fit" : ""),
      "swap the two image folders (or the two calibrations), or check the sign of the baseline",
      ExitCode::kCalibration};
}

void check_vision(Sequence& sequence, int frames, Findings& findings) {
  const auto order = check_stereo_order(sequence);
  if (order) findings.add(*order);
  auto* const recorded = dynamic_cast<ExchangeableSequence*>(&sequence);
  VisualProbe probe(sequence.camera());
  const auto end = std::min(sequence.frame_count(), static_cast<std::size_t>(frames));
  for (std::size_t i = 0; i < end; ++i) {
    // With the images the right way round the rest can be checked all the same.
    probe.add(order && recorded != nullptr ? recorded->read_exchanged_frame(i)
                                           : sequence.read_frame(i));
  }
  if (probe.row_differences().size() < kMinMatches) {
    findings.warn(
        fmt::format("only {} stereo matches in {} frames", probe.row_differences().size(), end),
        "the images hold little texture, are dark, or are no stereo pair");
    return;
  }
  check_rows(probe, findings);
  if (!sequence.imu()) return;
  const lie::SE3d& T_body_left = sequence.camera().T_body_left;
  const auto& samples = sequence.imu()->samples;
  const RotationComparison comparison =
      compare_rotations(probe.rotations(), samples, T_body_left.rotation());
  if (!comparison.valid) {
    findings.info(
        fmt::format("vision against gyro: no common motion seen ({} intervals, {:.0f} deg "
                    "of rotation, correlation {:.2f}); extrinsics and clock were not "
                    "checked",
                    comparison.intervals, comparison.angle_rad * kDegrees, comparison.correlation));
    return;
  }
  judge_rotations(comparison, T_body_left.rotation(), findings);
  judge_clock(comparison, findings);
  judge_scale(compare_scale(probe.rotations(), samples, T_body_left, comparison.time_offset_s),
              findings);
}

}  // namespace imslam::datasets

#include "slam/evaluation/kitti.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/evaluation/errors.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

namespace imslam::evaluation {
namespace {

constexpr std::size_t kFewestPerBin = 3;
constexpr double kDegreesPer100m = 100.0 * kDegreesPerRadian;

double devkit_angle(const Eigen::Matrix3d& R) {
  return std::acos(std::clamp(0.5 * (R.trace() - 1.0), -1.0, 1.0));
}

DriftSegment segment_error(const PosePath& reference,
                           const PosePath& estimate,
                           std::size_t first,
                           std::size_t last,
                           double length_m) {
  // The full inverse, as in the devkit: these matrices are orthonormal to seven digits only.
  const Eigen::Matrix4d Q_i_j = reference.poses[first].inverse() * reference.poses[last];
  const Eigen::Matrix4d P_i_j = estimate.poses[first].inverse() * estimate.poses[last];
  const Eigen::Matrix4d E = P_i_j.inverse() * Q_i_j;
  DriftSegment segment;
  segment.first = first;
  segment.rotation_per_m = devkit_angle(rotation(E)) / length_m;
  segment.translation = position(E).norm() / length_m;
  segment.length_m = length_m;
  return segment;
}

template <typename Belongs>
void add_bin(std::vector<DriftBin>& bins,
             const std::vector<DriftSegment>& segments,
             double key,
             const Belongs& belongs) {
  DriftBin bin;
  bin.key = key;
  for (const DriftSegment& segment : segments) {
    if (!belongs(segment)) continue;
    ++bin.count;
    bin.t_percent += 100.0 * segment.translation;
    bin.r_deg_per_100m += kDegreesPer100m * segment.rotation_per_m;
  }
  if (bin.count < kFewestPerBin) return;
  bin.t_percent /= static_cast<double>(bin.count);
  bin.r_deg_per_100m /= static_cast<double>(bin.count);
  bins.push_back(bin);
}

void summarise(Drift& drift, const DriftOptions& options) {
  if (drift.segments.empty()) return;
  double t = 0.0;
  double r = 0.0;
  for (const DriftSegment& segment : drift.segments) {
    t += segment.translation;
    r += segment.rotation_per_m;
  }
  const auto n = static_cast<double>(drift.segments.size());
  drift.t_rel_percent = 100.0 * t / n;
  drift.r_rel_deg_per_100m = kDegreesPer100m * r / n;
  for (const double length : options.lengths_m) {
    add_bin(drift.by_length, drift.segments, length,
            [&](const DriftSegment& s) { return s.length_m == length; });
  }
  for (double speed = 2.0; speed < 25.0; speed += 2.0) {
    add_bin(drift.by_speed, drift.segments, speed,
            [&](const DriftSegment& s) { return std::abs(s.speed_mps - speed) < 2.0; });
  }
}

}  // namespace

Drift kitti_drift(const PosePath& reference,
                  const PosePath& estimate,
                  const DriftOptions& options) {
  expects(reference.size() == estimate.size(), "kitti_drift: paths must be paired");
  expects(options.step > 0, "kitti_drift: step must be positive");
  const std::vector<double> along = distances_along(reference);
  Drift drift;
  for (std::size_t i = 0; i < along.size(); i += options.step) {
    for (const double length : options.lengths_m) {
      const auto end = std::upper_bound(along.begin() + static_cast<std::ptrdiff_t>(i), along.end(),
                                        along[i] + length);
      if (end == along.end()) continue;
      const auto j = static_cast<std::size_t>(end - along.begin());
      DriftSegment segment = segment_error(reference, estimate, i, j, length);
      segment.speed_mps = length / (options.frame_interval_s * static_cast<double>(j - i + 1));
      drift.segments.push_back(segment);
    }
  }
  summarise(drift, options);
  return drift;
}

Drift sub_trajectory_drift(const PosePath& reference, const PosePath& estimate) {
  const double length = distances_along(reference).back();
  if (!(length > 0.0)) return {};
  DriftOptions options;
  options.step = 1;
  options.lengths_m.clear();
  for (const double share : {0.1, 0.2, 0.3, 0.4, 0.5}) options.lengths_m.push_back(share * length);
  return kitti_drift(reference, estimate, options);
}

std::string devkit_errors(const Drift& drift) {
  std::string text;
  for (const DriftSegment& s : drift.segments) {
    text += fmt::format("{} {:f} {:f} {:f} {:f}\n", s.first, s.rotation_per_m, s.translation,
                        s.length_m, s.speed_mps);
  }
  return text;
}

}  // namespace imslam::evaluation

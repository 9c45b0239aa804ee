#include <algorithm>
#include <cmath>
#include <optional>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/evaluation/errors.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

// Which poses a relative error compares. The rules are evo's, quirks included: the figures have to
// agree with other people's.

namespace imslam::evaluation {
namespace {

double angle_between(const Eigen::Matrix4d& A, const Eigen::Matrix4d& B) {
  return rotation_angle(rotation(A).transpose() * rotation(B));
}

std::vector<PosePair> frame_pairs(std::size_t poses, std::size_t delta, bool all_pairs) {
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i + delta < poses; i += all_pairs ? 1 : delta) {
    pairs.emplace_back(i, i + delta);
  }
  return pairs;
}

/// A chain: a pose is a link when `delta` has been travelled since the last link. The first pose
/// is no link, so the first stretch is never measured.
std::vector<PosePair> distance_chain(const PosePath& path, double delta) {
  std::vector<PosePair> pairs;
  std::optional<std::size_t> last_link;
  double travelled = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    travelled += (position(path.poses[i]) - position(path.poses[i - 1])).norm();
    if (travelled < delta) continue;
    if (last_link) pairs.emplace_back(*last_link, i);
    last_link = i;
    travelled = 0.0;
  }
  return pairs;
}

/// From every pose i to the later pose whose distance along the path is nearest to delta.
std::vector<PosePair> distance_all_pairs(const PosePath& path, double delta, double tolerance) {
  std::vector<PosePair> pairs;
  const std::vector<double> along = distances_along(path);
  for (std::size_t i = 0; i + 1 < along.size(); ++i) {
    const auto miss = [&](std::size_t j) { return std::abs((along[j] - along[i]) - delta); };
    const auto begin = along.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    const auto reached = std::lower_bound(begin, along.end(), delta,
                                          [&](double s, double d) { return s - along[i] < d; });
    auto j = static_cast<std::size_t>(reached - along.begin());
    if (j == along.size() || (j > i + 1 && miss(j - 1) <= miss(j))) --j;
    while (j > i + 1 && miss(j - 1) <= miss(j)) --j;  // the first of several equally near
    if (miss(j) <= tolerance) pairs.emplace_back(i, j);
  }
  return pairs;
}

/// A chain of turns: the angles from pose to pose are summed until they reach delta.
std::vector<PosePair> angle_chain(const PosePath& path, double delta) {
  std::vector<PosePair> pairs;
  std::size_t start = 0;
  double turned = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    turned += angle_between(path.poses[i - 1], path.poses[i]);
    if (turned < delta) continue;
    pairs.emplace_back(start, i);
    start = i;
    turned = 0.0;
  }
  return pairs;
}

/// Every two poses whose orientations differ by delta, give or take the tolerance: O(n^2).
std::vector<PosePair> angle_all_pairs(const PosePath& path, double delta, double tolerance) {
  std::vector<std::vector<PosePair>> rows(path.size());
  parallel_for(path.size(), [&](std::size_t i) {
    for (std::size_t j = i + 1; j < path.size(); ++j) {
      const double angle = angle_between(path.poses[i], path.poses[j]);
      if (angle >= delta - tolerance && angle <= delta + tolerance) rows[i].emplace_back(i, j);
    }
  });
  std::vector<PosePair> pairs;
  for (const auto& row : rows) pairs.insert(pairs.end(), row.begin(), row.end());
  return pairs;
}

}  // namespace

std::vector<double> distances_along(const PosePath& path) {
  std::vector<double> along(path.size(), 0.0);
  for (std::size_t i = 1; i < path.size(); ++i) {
    along[i] = along[i - 1] + (position(path.poses[i]) - position(path.poses[i - 1])).norm();
  }
  return along;
}

std::vector<PosePair> select_pairs(const PosePath& path, const DeltaOptions& options) {
  options.validate();
  double delta = options.delta;
  if (options.unit == DeltaUnit::kDegrees) delta /= kDegreesPerRadian;
  const double tolerance = delta * options.relative_tolerance;
  switch (options.unit) {
    case DeltaUnit::kFrames:
      return frame_pairs(path.size(), static_cast<std::size_t>(options.delta), options.all_pairs);
    case DeltaUnit::kMeters:
      return options.all_pairs ? distance_all_pairs(path, delta, tolerance)
                               : distance_chain(path, delta);
    case DeltaUnit::kDegrees:
    case DeltaUnit::kRadians:
      return options.all_pairs ? angle_all_pairs(path, delta, tolerance) : angle_chain(path, delta);
  }
  return {};
}

}  // namespace imslam::evaluation

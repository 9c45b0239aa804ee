#include "slam/evaluation/errors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "slam/base/error.hpp"
#include "slam/evaluation/names.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

namespace imslam::evaluation {
namespace {

double error_of(const Eigen::Matrix4d& E, Relation relation) {
  switch (relation) {
    case Relation::kRotationPart:
      return (rotation(E) - Eigen::Matrix3d::Identity()).norm();
    case Relation::kFullTransformation:
      return (E - Eigen::Matrix4d::Identity()).norm();
    case Relation::kRotationAngleRad:
      return rotation_angle(rotation(E));
    case Relation::kRotationAngleDeg:
      return rotation_angle(rotation(E)) * kDegreesPerRadian;
    case Relation::kTranslationPart:
    case Relation::kPointDistance:
    case Relation::kPointDistanceErrorRatio:
      break;
  }
  return position(E).norm();
}

double distance(const PosePath& path, const PosePair& pair) {
  return (position(path.poses[pair.second]) - position(path.poses[pair.first])).norm();
}

/// evo prints the number of frames as an integer and everything else as a float.
std::string no_pairs_message(const DeltaOptions& options) {
  return delta_text(options) +
         " produced an empty index list - try lower values or a less strict tolerance";
}

ErrorSeries distance_errors(const PosePath& reference,
                            const PosePath& estimate,
                            const std::vector<PosePair>& pairs,
                            bool as_ratio) {
  ErrorSeries series;
  for (const PosePair& pair : pairs) {
    const double expected = distance(reference, pair);
    const double error = std::abs(expected - distance(estimate, pair));
    if (as_ratio && expected == 0.0) {
      ++series.dropped;
      continue;
    }
    series.errors.push_back(as_ratio ? 100.0 * (error / expected) : error);
    series.poses.push_back(pair.second);
  }
  if (series.errors.empty()) {
    throw InputError("the reference does not move between any two poses: no error ratio",
                     ExitCode::kEvaluation);
  }
  return series;
}

}  // namespace

void DeltaOptions::validate() const {
  const auto require = [](bool condition, const std::string& message) {
    if (!condition) throw InputError(message, ExitCode::kUsage);
  };
  require(std::isfinite(delta) && delta > 0.0,
          fmt::format("delta = {}: must be greater than 0", delta));
  require(std::isfinite(relative_tolerance) && relative_tolerance >= 0.0,
          fmt::format("delta-tol = {}: must not be negative", relative_tolerance));
  require(unit != DeltaUnit::kFrames || (delta == std::floor(delta) && delta < 1e15),
          fmt::format("delta = {}: must be an integer with unit frames", delta));
  require(unit != DeltaUnit::kDegrees || delta <= 180.0,
          fmt::format("delta = {}: at most 180 with unit degrees", delta));
  require(unit != DeltaUnit::kRadians || delta <= kPi,
          fmt::format("delta = {}: at most pi with unit radians", delta));
}

ErrorSeries absolute_errors(const PosePath& reference,
                            const PosePath& estimate,
                            Relation relation) {
  expects(reference.size() == estimate.size(), "absolute_errors: paths must be paired");
  if (relation == Relation::kPointDistanceErrorRatio) {
    throw InputError("point_distance_error_ratio compares two poses: use it with --metric rpe",
                     ExitCode::kUsage);
  }
  const bool positions_only =
      relation == Relation::kTranslationPart || relation == Relation::kPointDistance;
  ErrorSeries series;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const Eigen::Matrix4d& P = estimate.poses[i];
    const Eigen::Matrix4d& Q = reference.poses[i];
    series.errors.push_back(positions_only ? (position(P) - position(Q)).norm()
                                           : error_of(relative_pose(P, Q), relation));
    series.poses.push_back(i);
  }
  return series;
}

ErrorSeries relative_errors(const PosePath& reference,
                            const PosePath& estimate,
                            Relation relation,
                            const DeltaOptions& options) {
  expects(reference.size() == estimate.size(), "relative_errors: paths must be paired");
  const auto pairs = select_pairs(options.pairs_from_reference ? reference : estimate, options);
  if (pairs.empty()) throw InputError(no_pairs_message(options), ExitCode::kEvaluation);
  if (relation == Relation::kPointDistance || relation == Relation::kPointDistanceErrorRatio) {
    return distance_errors(reference, estimate, pairs,
                           relation == Relation::kPointDistanceErrorRatio);
  }
  ErrorSeries series;
  for (const auto& [i, j] : pairs) {
    const Eigen::Matrix4d Q_i_j = relative_pose(reference.poses[i], reference.poses[j]);
    const Eigen::Matrix4d P_i_j = relative_pose(estimate.poses[i], estimate.poses[j]);
    series.errors.push_back(error_of(relative_pose(Q_i_j, P_i_j), relation));
    series.poses.push_back(j);
  }
  return series;
}

}  // namespace imslam::evaluation

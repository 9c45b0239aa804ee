#include "slam/evaluation/evaluate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/evaluation/errors.hpp"
#include "slam/evaluation/path_checks.hpp"
#include "slam/evaluation/rigid_matrix.hpp"
#include "slam/evaluation/statistics.hpp"

namespace imslam::evaluation {
namespace {

constexpr double kNotableDifference = 0.05;
constexpr double kLargestTilt = 20.0 / kDegreesPerRadian;

double position_rmse(const PosePath& reference, const PosePath& estimate) {
  return statistics(absolute_errors(reference, estimate, Relation::kTranslationPart).errors).rmse;
}

double frame_rmse(const MatchedPaths& m, Relation relation) {
  return statistics(relative_errors(m.reference, m.estimate, relation, DeltaOptions{}).errors).rmse;
}

std::optional<double> rpe_over_one_metre(const MatchedPaths& m) {
  DeltaOptions options;
  options.unit = DeltaUnit::kMeters;
  options.all_pairs = true;
  if (select_pairs(m.estimate, options).empty()) return std::nullopt;
  const auto series = relative_errors(m.reference, m.estimate, Relation::kTranslationPart, options);
  return statistics(series.errors).rmse;
}

/// Aligns by SE(3), Sim(3) and yaw; says why where that is impossible.
void add_absolute_errors(const MatchedPaths& m,
                         const EvaluationOptions& options,
                         Evaluation& result) {
  AlignmentOptions yaw;
  yaw.kind = Alignment::kPosYaw;
  yaw.up_reference = options.up_reference;
  yaw.up_estimate = options.up_estimate;
  result.ate_posyaw_rmse_m =
      position_rmse(m.reference, align(m.reference, m.estimate, yaw).estimate);
  PosePath aligned;
  try {
    const AlignedPath se3 = align(m.reference, m.estimate, {Alignment::kSe3});
    result.ate_se3_rmse_m = position_rmse(m.reference, se3.estimate);
    result.se3 = se3.transform;
    aligned = se3.estimate;
    const AlignedPath sim3 = align(m.reference, m.estimate, {Alignment::kSim3});
    result.ate_sim3_rmse_m = position_rmse(m.reference, sim3.estimate);
    result.scale = sim3.transform.scale;
  } catch (const InputError& error) {
    result.warnings.emplace_back(error.what());
    const AlignedPath origin = align(m.reference, m.estimate, {Alignment::kOrigin});
    result.se3 = origin.transform;
    aligned = origin.estimate;
  }
  const Eigen::Vector3d up = result.se3.R * options.up_estimate.normalized();
  const double tilt = std::acos(std::clamp(up.dot(options.up_reference.normalized()), -1.0, 1.0));
  if (result.ate_se3_rmse_m && result.se3.flatness > 1e-4 && tilt > kLargestTilt) {
    result.warnings.push_back(fmt::format(
        "the verticals of the two worlds are {:.0f} deg apart: the yaw-only alignment is not "
        "meaningful; say which axis is vertical (--vertical)",
        tilt * kDegreesPerRadian));
  }
  PoseErrors& poses = result.poses;
  poses.position_m = absolute_errors(m.reference, aligned, Relation::kTranslationPart).errors;
  poses.rotation_rad = absolute_errors(m.reference, aligned, Relation::kRotationAngleRad).errors;
  poses.reference_m = positions_of(m.reference);
  poses.estimate_m = positions_of(aligned);
  poses.times_s = m.reference.stamps_s;
  for (std::size_t i = poses.times_s.size(); i < m.reference.size(); ++i) {
    poses.times_s.push_back(static_cast<double>(i));
  }
}

void add_end_errors(const MatchedPaths& m, Evaluation& result) {
  const Eigen::Matrix4d Q = relative_pose(m.reference.poses.front(), m.reference.poses.back());
  const Eigen::Matrix4d P = relative_pose(m.estimate.poses.front(), m.estimate.poses.back());
  const Eigen::Matrix4d E = relative_pose(Q, P);
  result.rotation_end_deg = rotation_angle(rotation(E)) * kDegreesPerRadian;
  constexpr double kAtRest_m = 1e-3;  // rounding alone makes a path of some 1e-15 m
  if (result.path_length_m > kAtRest_m) {
    result.end_error_percent = 100.0 * position(E).norm() / result.path_length_m;
  }
}

void add_drift(const MatchedPaths& m, const EvaluationOptions& options, Evaluation& result) {
  DriftOptions drift;
  drift.frame_interval_s = options.frame_interval_s;
  if (m.reference.has_stamps()) {
    const auto steps = static_cast<double>(m.reference.size() - 1);
    const double span = m.reference.stamps_s.back() - m.reference.stamps_s.front();
    if (span > 0.0) drift.frame_interval_s = span / steps;
  }
  result.kitti = kitti_drift(m.reference, m.estimate, drift);
  result.sub_trajectories = sub_trajectory_drift(m.reference, m.estimate);
  if (result.kitti.segments.empty()) return;
  result.t_rel_percent = result.kitti.t_rel_percent;
  result.r_rel_deg_per_100m = result.kitti.r_rel_deg_per_100m;
}

bool differs(double nearest, double interpolated) {
  return std::abs(nearest - interpolated) > kNotableDifference * std::max(nearest, interpolated);
}

/// With interpolation the error of at most half a reference interval falls away; worth a line
/// where it was a notable part of the figure.
void add_interpolated(const PosePath& reference,
                      const PosePath& estimate,
                      const EvaluationOptions& options,
                      Evaluation& result) {
  if (!reference.has_stamps() || options.association.interpolate) return;
  AssociationOptions association = options.association;
  association.interpolate = true;
  MatchedPaths m;
  try {
    m = associate(reference, estimate, association);
  } catch (const InputError&) {
    return;  // the reference is too sparse
  }
  if (m.estimate.size() < 2) return;
  InterpolatedFigures figures;
  figures.matched = m.estimate.size();
  figures.rpe_frame_rmse_m = frame_rmse(m, Relation::kTranslationPart);
  figures.rpe_frame_rmse_deg = frame_rmse(m, Relation::kRotationAngleDeg);
  if (result.ate_se3_rmse_m) {
    try {
      figures.ate_se3_rmse_m =
          position_rmse(m.reference, align(m.reference, m.estimate, {Alignment::kSe3}).estimate);
    } catch (const InputError&) {
      figures.ate_se3_rmse_m.reset();
    }
  }
  const bool notable =
      differs(result.rpe_frame_rmse_m, figures.rpe_frame_rmse_m) ||
      differs(result.rpe_frame_rmse_deg, figures.rpe_frame_rmse_deg) ||
      (figures.ate_se3_rmse_m && differs(*result.ate_se3_rmse_m, *figures.ate_se3_rmse_m));
  if (notable) result.interpolated = figures;
}

void append(std::vector<std::string>& all, std::vector<std::string> more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

void EvaluationOptions::describe(Config& config) {
  config.field("max_time_difference_s", association.max_difference_s,
               "poses further apart in time are not compared [s]");
  config.field("time_offset_s", association.offset_s, "added to the estimate's stamps [s]");
  config.field("interpolate", association.interpolate,
               "interpolate the reference instead of taking the nearest pose");
  config.field("max_gap_s", association.max_gap_s,
               "no interpolation across larger holes of the reference [s]");
}

void EvaluationOptions::validate() const {
  association.validate();
  const auto require = [](bool condition, const char* message) {
    if (!condition) throw InputError(message, ExitCode::kUsage);
  };
  require(T_body_eval.allFinite() && rotation_defect(rotation(T_body_eval)) < 1e-3,
          "T-body-eval: its rotation must be orthonormal to 1e-3");
  require(up_reference.allFinite() && up_reference.norm() > 0.0 && up_estimate.allFinite() &&
              up_estimate.norm() > 0.0,
          "vertical: must be a direction, not zero");
  require(frame_interval_s > 0.0, "frame_interval_s: must be greater than 0");
}

Evaluation evaluate(const PosePath& reference,
                    const PosePath& given_estimate,
                    const EvaluationOptions& options) {
  options.validate();
  require_evaluable(reference);
  require_evaluable(given_estimate);
  const PosePath estimate = moved_to_frame(given_estimate, options.T_body_eval);
  const MatchedPaths m = associate(reference, estimate, options.association);
  if (m.estimate.size() < 2) {
    throw InputError("only one pose matches; at least two are needed", ExitCode::kEvaluation);
  }
  Evaluation result;
  result.warnings = m.warnings;
  append(result.warnings, frame_warnings(m));
  result.matched = m.estimate.size();
  result.stamped = reference.has_stamps();
  result.reference_poses = m.reference_poses;
  result.estimate_poses = m.estimate_poses;
  result.coverage = m.coverage;
  result.time_coverage = m.time_coverage;
  result.path_length_m = distances_along(m.reference).back();
  add_absolute_errors(m, options, result);
  result.rpe_frame_rmse_m = frame_rmse(m, Relation::kTranslationPart);
  result.rpe_frame_rmse_deg = frame_rmse(m, Relation::kRotationAngleDeg);
  result.rpe_1m_rmse_m = rpe_over_one_metre(m);
  add_drift(m, options, result);
  add_end_errors(m, result);
  add_interpolated(reference, estimate, options, result);
  return result;
}

PosePath to_pose_path(const Trajectory& trajectory, const std::string& source) {
  expects(trajectory.times_ns.size() == trajectory.poses.size(),
          "to_pose_path: as many stamps as poses");
  PosePath path;
  path.frame = trajectory.frame;
  path.source = source;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    // long double holds every int64: the same double as the decimal text of a TUM file gives.
    const long double seconds = static_cast<long double>(trajectory.times_ns[i]) / 1e9L;
    path.stamps_s.push_back(static_cast<double>(seconds));
    path.poses.push_back(trajectory.poses[i].matrix());
  }
  return path;
}

}  // namespace imslam::evaluation

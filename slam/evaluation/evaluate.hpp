#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "slam/evaluation/align.hpp"
#include "slam/evaluation/associate.hpp"
#include "slam/evaluation/kitti.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam {
class Config;
}

namespace imslam::evaluation {

struct EvaluationOptions {
  AssociationOptions association;
  /// The estimate's poses are carried to the frame of the reference: P T_body_eval.
  Eigen::Matrix4d T_body_eval = Eigen::Matrix4d::Identity();
  Eigen::Vector3d up_reference = Eigen::Vector3d::UnitZ();  ///< vertical of its world (yaw axis)
  Eigen::Vector3d up_estimate = Eigen::Vector3d::UnitZ();   ///< vertical of its world (yaw axis)
  double frame_interval_s = 0.1;  ///< [s], KITTI speed bins of paths without stamps

  void describe(Config& config);
  void validate() const;
};

/// One pose's errors, for plots; the estimate aligned by SE(3), or by its first pose where the
/// positions do not determine a rotation.
struct PoseErrors {
  std::vector<double> times_s;               ///< of the reference; pose numbers without stamps
  std::vector<double> position_m;            ///< [m]
  std::vector<double> rotation_rad;          ///< [rad]
  std::vector<Eigen::Vector3d> reference_m;  ///< [m], reference world
  std::vector<Eigen::Vector3d> estimate_m;   ///< [m], reference world
};

/// The same figures with the reference interpolated at the estimate's stamps.
struct InterpolatedFigures {
  std::size_t matched = 0;
  std::optional<double> ate_se3_rmse_m;
  double rpe_frame_rmse_m = 0.0;
  double rpe_frame_rmse_deg = 0.0;
};

/// Everything a run reports about a trajectory with truth. What a path does not determine is
/// empty, with the reason in `warnings`; nothing is ever NaN.
struct Evaluation {
  std::optional<double> ate_se3_rmse_m;     ///< [m], evo_ape -a
  std::optional<double> ate_posyaw_rmse_m;  ///< [m], yaw and translation aligned
  std::optional<double> ate_sim3_rmse_m;    ///< [m], evo_ape -as
  std::optional<double> scale;              ///< by which -as multiplies the estimate
  std::optional<double> rpe_1m_rmse_m;      ///< [m], evo_rpe -d 1 -u m --all_pairs
  double rpe_frame_rmse_m = 0.0;            ///< [m], evo_rpe -d 1 -u f
  double rpe_frame_rmse_deg = 0.0;          ///< [deg], the same, -r angle_deg
  std::optional<double> t_rel_percent;      ///< KITTI; needs more than 100 m
  std::optional<double> r_rel_deg_per_100m;
  double rotation_end_deg = 0.0;            ///< [deg], of the motion from first to last pose
  std::optional<double> end_error_percent;  ///< of path_length_m, same motion; empty at rest
  double path_length_m = 0.0;               ///< [m], of the matched reference

  std::size_t matched = 0;
  std::size_t reference_poses = 0;
  std::size_t estimate_poses = 0;
  bool stamped = true;         ///< false: poses were matched by their order
  double coverage = 0.0;       ///< matched share of the shorter path
  double time_coverage = 0.0;  ///< share of the reference's duration

  /// Present where the nearest stamps cost more than 5 % of a figure.
  std::optional<InterpolatedFigures> interpolated;
  Drift kitti;             ///< segments of 100..800 m
  Drift sub_trajectories;  ///< segments of 10..50 % of the length, for paths of any length
  PoseErrors poses;
  Similarity se3;  ///< from the estimate's world to the reference's, as used in `poses`
  std::vector<std::string> warnings;
};

/// Compares an estimate with the truth. Association is evo's: nearest stamps within 0.01 s.
/// Throws InputError(kEvaluation) if nothing matches, only one pose does, or poses are not finite.
Evaluation evaluate(const PosePath& reference,
                    const PosePath& estimate,
                    const EvaluationOptions& options = {});

/// Stamps in double seconds, as they would be read back from a file.
PosePath to_pose_path(const Trajectory& trajectory, const std::string& source = "estimate");

}  // namespace imslam::evaluation

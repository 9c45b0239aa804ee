#pragma once

#include <map>
#include <optional>
#include <vector>

#include "slam/evaluation/evaluate.hpp"
#include "slam/evaluation/motion_consistency.hpp"
#include "slam/sensors/trajectory.hpp"
#include "slam/system/slam_result.hpp"

namespace imslam::system {

/// Translation errors [m] of the motions over 1, 2, 5, ... m of path, for box plots.
using ErrorsByLength = std::map<int, std::vector<double>>;

/// The errors of a run's trajectories, where there is truth.
struct RunEvaluation {
  evaluation::Evaluation vo;
  evaluation::Evaluation graph;
  std::optional<evaluation::Evaluation> online;
  std::optional<evaluation::MotionConsistency> vo_consistency;  ///< of the edges between frames
  ErrorsByLength vo_by_length;
  ErrorsByLength graph_by_length;
  Trajectory truth;  ///< T_world_body in the world of the graph, for the report
};

/// Compares all trajectories of a run with the truth, in the frame of the truth (KITTI: camera 0).
///
/// T_body_truth carries the estimate's body to the frame that the truth is of.
/// Throws InputError(kEvaluation) with the reason if nothing can be compared.
RunEvaluation evaluate_run(const SlamResult& result,
                           const PosePath& truth,
                           const lie::SE3d& T_body_truth);

}  // namespace imslam::system

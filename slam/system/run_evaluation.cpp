#include "slam/system/run_evaluation.hpp"

#include <array>
#include <cmath>

#include "slam/base/time.hpp"
#include "slam/evaluation/errors.hpp"

namespace imslam::system {
namespace {

constexpr std::array<int, 6> kLengths = {1, 2, 5, 10, 20, 50};  // [m]

PosePath in_frame_of_truth(const Trajectory& trajectory,
                           const lie::SE3d& T_body_truth,
                           const std::string& frame) {
  PosePath path = evaluation::to_pose_path(trajectory);
  path.frame = frame;
  const Eigen::Matrix4d T = T_body_truth.matrix();
  for (Eigen::Matrix4d& pose : path.poses) pose = (pose * T).eval();
  return path;
}

ErrorsByLength errors_by_length(const PosePath& truth, const PosePath& estimate) {
  ErrorsByLength result;
  const auto matched = evaluation::associate(truth, estimate);
  for (const int length : kLengths) {
    evaluation::DeltaOptions delta;
    delta.delta = length;
    delta.unit = evaluation::DeltaUnit::kMeters;
    delta.all_pairs = true;
    delta.pairs_from_reference = true;
    if (evaluation::select_pairs(matched.reference, delta).empty()) continue;
    result[length] = evaluation::relative_errors(matched.reference, matched.estimate,
                                                 evaluation::Relation::kTranslationPart, delta)
                         .errors;
  }
  return result;
}

/// What vision measured between neighbouring frames.
std::vector<RelativeMotion> steps_of_vision(const SlamResult& result) {
  std::vector<RelativeMotion> motions;
  for (const pgo::VisualEdge& edge : result.graph_data.visual_edges) {
    if (edge.to == edge.from + 1) motions.push_back(edge.motion);
  }
  return motions;
}

/// The truth as a trajectory of the body in the world of the graph, over the time of the run.
Trajectory truth_in_graph_world(const PosePath& truth,
                                const evaluation::Similarity& to_truth_world,
                                const lie::SE3d& T_body_truth,
                                const Trajectory& graph) {
  Trajectory result;
  if (!truth.has_stamps() || graph.size() == 0) return result;
  const lie::SE3d T_truth_world_world(lie::SO3d::from_matrix(to_truth_world.R), to_truth_world.t);
  const lie::SE3d T_world_truth_world = T_truth_world_world.inverse();
  const lie::SE3d T_truth_body = T_body_truth.inverse();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto time_ns =
        static_cast<std::int64_t>(std::llround(truth.stamps_s[i] * kNanosecondsPerSecond));
    const bool inside = time_ns >= graph.times_ns.front() && time_ns <= graph.times_ns.back();
    const bool later = result.times_ns.empty() || time_ns > result.times_ns.back();
    if (!inside || !later) continue;
    result.add(time_ns,
               T_world_truth_world * lie::SE3d::from_matrix(truth.poses[i]) * T_truth_body);
  }
  return result;
}

}  // namespace

RunEvaluation evaluate_run(const SlamResult& result,
                           const PosePath& truth,
                           const lie::SE3d& T_body_truth) {
  const PosePath graph = in_frame_of_truth(result.graph, T_body_truth, truth.frame);
  const PosePath vo = in_frame_of_truth(result.vo_only, T_body_truth, truth.frame);
  evaluation::EvaluationOptions options;
  // KITTI's worlds are those of a camera: y points down.
  if (truth.frame == "left") options.up_reference = -Eigen::Vector3d::UnitY();
  RunEvaluation run;
  run.graph = evaluation::evaluate(truth, graph, options);
  run.vo = evaluation::evaluate(truth, vo, options);
  if (result.online.size() > 1) {
    const PosePath online = in_frame_of_truth(result.online, T_body_truth, truth.frame);
    run.online = evaluation::evaluate(truth, online, options);
  }
  if (!result.inertial) {
    // Without gravity the estimate's world has no vertical to turn about.
    run.graph.ate_posyaw_rmse_m.reset();
    run.vo.ate_posyaw_rmse_m.reset();
  }
  run.vo_consistency = evaluation::motion_consistency(steps_of_vision(result), truth, T_body_truth);
  run.graph_by_length = errors_by_length(truth, graph);
  run.vo_by_length = errors_by_length(truth, vo);
  run.truth = truth_in_graph_world(truth, run.graph.se3, T_body_truth, result.graph);
  return run;
}

}  // namespace imslam::system

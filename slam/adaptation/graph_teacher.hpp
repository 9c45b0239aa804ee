#pragma once

#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "pgo/edge_likelihood.hpp"
#include "pgo/posterior.hpp"
#include "slam/adaptation/adaptation_options.hpp"
#include "slam/adaptation/whole_gradient.hpp"
#include "slam/system/slam_result.hpp"
#include "slam/training/inertial_log.hpp"
#include "vo_net/motion_cost.hpp"

namespace imslam::adaptation {

/// What the solved graph of a run knows better than the measurements that went into it.
///
///   U = sum over edges of the likelihood of each measurement, foretold by all the others
///       (upper: left_out), or at the solution itself, U = L (upper: joint); pgo::EdgeLikelihood
///
/// or what the published code minimises (upper: published); WholeGradient
///
///       + loop_weight x the likelihood of the motions that close loops; WholeGradient, implicit
///
/// The states are the stationary point of the joint likelihood: of U = L the derivative by a
/// measurement at the solution is the whole one ("one step") as long as the solve has converged.
class GraphTeacher {
 public:
  /// Empty, with the reason, if the graph cannot teach: not converged, or not determined.
  static std::optional<GraphTeacher> of(const system::SlamResult& result,
                                        const AdaptationOptions& options,
                                        std::string& reason);
  /// Of a graph that has been solved, e.g. a sliding window.
  static std::optional<GraphTeacher> of(pgo::PoseVelocityGraph graph,
                                        const AdaptationOptions& options,
                                        std::string& reason);

  const pgo::PoseVelocityGraph& graph() const { return graph_; }
  const pgo::Posterior& posterior() const { return posterior_; }

  /// The odometry's edge over this interval, if the graph has it.
  std::optional<std::size_t> visual_edge(std::int64_t time0_ns, std::int64_t time1_ns) const;
  /// U of that edge for another measurement in its place.
  vo::MotionCost cost_of(std::size_t visual_edge) const;
  /// The same of an inertial edge.
  pgo::EdgeLikelihood<9> inertial(std::size_t edge, const ImuMotion& motion) const;
  /// The motion as the solution has it.
  lie::SE3d T_body0_body1(std::size_t visual_edge) const;
  double disparity_offset() const { return graph_.globals().disparity_offset; }

  /// Mean over the edges whose later frame counts of how badly all other measurements foretell
  /// them, per dimension: the self-supervised loss that networks are chosen
  /// by. 0 without such edges.
  double left_out_loss(const std::function<bool(std::size_t state)>& counts) const;

  /// The graph's trajectory as though it were the truth about the inertial sensor. `samples` are
  /// raw readings.
  training::InertialLog inertial_log(const std::vector<ImuSample>& samples,
                                     const ImuNoise& noise) const;

 private:
  GraphTeacher(pgo::PoseVelocityGraph graph,
               pgo::Posterior posterior,
               bool joint,
               std::optional<WholeGradient> whole,
               std::optional<WholeGradient> loops,
               double loop_weight);

  vo::MotionCost own_cost_of(std::size_t visual_edge) const;
  pgo::EdgeLikelihood<9> own_inertial(std::size_t edge, const ImuMotion& motion) const;

  pgo::PoseVelocityGraph graph_;
  pgo::Posterior posterior_;
  bool joint_;
  std::optional<WholeGradient> whole_;  ///< of an upper cost that is not the graph's own
  std::optional<WholeGradient> loops_;  ///< of the term that is added
  double loop_weight_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> visual_edges_;  ///< by their times
};

}  // namespace imslam::adaptation

#pragma once

#include <memory>
#include <optional>
#include <string>

#include "pgo/edge_likelihood.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "slam/adaptation/adaptation_options.hpp"
#include "slam/system/measurement_coordinates.hpp"
#include "slam/system/slam_upper_cost.hpp"
#include "vo_net/motion_cost.hpp"

namespace imslam::adaptation {

/// The slopes of an upper cost U that is not the graph's own, by every measurement of the graph at
/// once, through a strategy of the learner:
///
///   one_step   dU/dz with the states held: what the published code takes for the gradient
///   implicit   the whole derivative, the states following the measurements
///
/// U stays what it was at the solution: its slopes do not know how the networks move until the
/// next solution.
class WholeGradient {
 public:
  /// Empty, with the reason, where the strategy refuses.
  static std::optional<WholeGradient> of(const pgo::PoseVelocityGraph& solved,
                                         const system::SlamUpperOptions& upper,
                                         const std::string& strategy,
                                         std::string& reason);

  vo::MotionSlope visual(std::size_t edge) const;
  pgo::EdgeLikelihood<9> inertial(std::size_t edge) const;

 private:
  WholeGradient(system::MeasurementCoordinates coordinates,
                Eigen::VectorXd z,
                Eigen::VectorXd dz,
                double cost_per_edge);

  system::MeasurementCoordinates coordinates_;
  Eigen::VectorXd z_;
  Eigen::VectorXd dz_;
  double cost_per_edge_ = 0.0;
};

/// What the published code minimises.
system::SlamUpperOptions published_upper(const AdaptationOptions& options);

/// The likelihood of the motions that close loops. Empty: there is none.
std::optional<system::SlamUpperOptions> loop_upper(const pgo::PoseVelocityGraph& solved,
                                                   const AdaptationOptions& options);

}  // namespace imslam::adaptation

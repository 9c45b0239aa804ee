#pragma once

#include <functional>
#include <optional>

#include "pgo/graph_point.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "slam/learner/lower_problem.hpp"
#include "slam/system/measurement_coordinates.hpp"

namespace imslam::system {

/// What the upper level makes of the solved graph.
enum class UpperKind {
  kGraph,  ///< U = L, the negative log-likelihood, or that of some edges only
  /// U = L + 1/2 log det J^T J: the states integrated out, so that a sigma that the states can meet
  /// exactly does not collapse (pgo::ResidualPosterior). J is held in the slopes, and no edges may
  /// be left out.
  kMarginal,
  kPublished,  ///< U = 1/2 sum |weight Log(P^-1 T_i^-1 T_j)|^2 over single steps of vision
};

struct SlamUpperOptions {
  UpperKind kind = UpperKind::kGraph;
  /// Edges that count, e.g. those of held-out stretches; empty: all, with kGraph the priors too.
  std::optional<pgo::EdgeSelection> only;
  double published_weight = 1.0;  ///< [1/m, 1/rad]: 1 (KITTI), 4 (EuRoC); slam.md, section 2
  /// One more term of the solved states and z, e.g. the likelihood of matches. Its `by_phi` is by
  /// the tangent of the states in the order of GraphPoint. Either slope may be empty: 0.
  std::function<learner::UpperValue(const pgo::GraphData& solved, const learner::Vector& z)> extra;
};

/// U and its slopes at a solved graph; `by_phi` is by the tangent of `point`.
learner::UpperValue slam_upper_cost(const SlamUpperOptions& options,
                                    const pgo::PoseVelocityGraph& solved,
                                    const pgo::GraphPoint& point,
                                    const MeasurementCoordinates& coordinates,
                                    const learner::Vector& z);

}  // namespace imslam::system

#pragma once

#include <ceres/ceres.h>

#include <array>
#include <deque>
#include <memory>
#include <vector>

#include "pgo/graph_data.hpp"
#include "pgo/imu_factor.hpp"
#include "pgo/marginal_prior_factor.hpp"
#include "pgo/options.hpp"
#include "pgo/prior_factors.hpp"
#include "pgo/relative_pose_factor.hpp"

namespace imslam::pgo {

/// Which bias walks a problem gets: between all neighbouring states, or the first two only.
enum class BiasWalks { kAuto, kFirst, kNone };

/// A GraphData laid out for Ceres. Lives for one solve; owns blocks and factors in a few large
/// pieces instead of one allocation each. Everything in it has a fixed order, so the result has
/// the same bits every time.
class GraphProblem {
 public:
  /// kAuto: all bias walks if the graph has anything inertial.
  GraphProblem(const GraphData& data,
               const GraphOptions& options,
               BiasWalks walks = BiasWalks::kAuto);
  GraphProblem(const GraphProblem&) = delete;
  GraphProblem& operator=(const GraphProblem&) = delete;

  ceres::Problem& problem() { return *problem_; }

  /// Residual blocks in the order of the data's edges.
  const std::vector<ceres::ResidualBlockId>& visual_residuals() const { return visual_ids_; }
  const std::vector<ceres::ResidualBlockId>& inertial_residuals() const { return inertial_ids_; }

  double* block(const BlockId& id);
  /// Free (not held constant) and touched by a factor.
  bool estimated(const BlockId& id);

  /// Copies the solution back; false and no change if any number is not finite.
  bool store(GraphData& data) const;

 private:
  void copy_blocks(const GraphData& data);
  void add_visual_edges(const GraphData& data);
  void add_inertial_edges(const GraphData& data);
  void add_bias_walks(const GraphData& data, BiasWalks walks);
  void add_state_priors(const GraphData& data);
  void add_global_priors(const GraphData& data);
  void add_marginal_prior(const GraphData& data);
  void set_manifolds();
  void hold_globals();

  GraphOptions options_;
  std::vector<std::array<double, 7>> poses_;
  std::vector<std::array<double, 3>> velocities_;
  std::vector<std::array<double, 6>> biases_;
  std::array<double, 3> gravity_direction_{};
  double disparity_offset_ = 0.0;
  double focal_error_ = 0.0;
  double time_offset_s_ = 0.0;
  std::array<double, 3> camera_rotation_{};
  std::array<double, 9> gyro_shape_{};  ///< row by row

  PoseManifold pose_manifold_;
  ceres::SphereManifold<3> direction_manifold_;
  std::unique_ptr<ceres::LossFunction> loss_;
  std::deque<RelativePoseFactor> visual_factors_;
  std::deque<ImuFactor> inertial_factors_;
  std::deque<BiasWalkFactor> bias_walks_;
  std::vector<std::unique_ptr<ceres::CostFunction>> priors_;
  std::vector<ceres::ResidualBlockId> visual_ids_;
  std::vector<ceres::ResidualBlockId> inertial_ids_;
  std::unique_ptr<ceres::Problem> problem_;  ///< last: it refers to all of the above
};

/// Whether anything in the graph speaks of biases: then they are estimated, and walk.
bool has_biases(const GraphData& data);

}  // namespace imslam::pgo

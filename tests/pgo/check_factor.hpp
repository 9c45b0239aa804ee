#pragma once

#include <ceres/gradient_checker.h>
#include <ceres/sphere_manifold.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pgo/pose_block.hpp"
#include "tests/support/numeric_jacobian.hpp"

namespace imslam::testing {

using Block = std::vector<double>;

inline Block pose_block(const lie::SE3d& pose) {
  Block block(7);
  pgo::pose_to_block(pose, block.data());
  return block;
}

inline Block vector_block(const Eigen::VectorXd& x) { return {x.data(), x.data() + x.size()}; }

/// Row by row.
inline Block shape_block(const Eigen::Matrix3d& shape) {
  const Eigen::Matrix3d columns = shape.transpose();
  return {columns.data(), columns.data() + 9};
}

/// Compares the analytic Jacobians of a factor, on the manifolds of its blocks, with Ridders'
/// numeric derivatives. Blocks of seven numbers are poses, those named are directions.
inline void expect_jacobians_match(const ceres::CostFunction& factor,
                                   const std::vector<Block>& blocks,
                                   int direction_block = -1,
                                   double tolerance = 1e-6) {
  const pgo::PoseManifold pose;
  const ceres::SphereManifold<3> direction;
  std::vector<const ceres::Manifold*> manifolds;
  std::vector<const double*> parameters;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const bool is_direction = static_cast<int>(i) == direction_block;
    manifolds.push_back(blocks[i].size() == 7 ? static_cast<const ceres::Manifold*>(&pose)
                        : is_direction        ? &direction
                                              : nullptr);
    parameters.push_back(blocks[i].data());
  }
  ceres::NumericDiffOptions numeric;
  numeric.ridders_relative_initial_step_size = 1e-3;  // must not step over a half turn
  ceres::GradientChecker checker(&factor, &manifolds, numeric);
  ceres::GradientChecker::ProbeResults results;
  checker.Probe(parameters.data(), tolerance, &results);  // its own verdict divides by zeros
  ASSERT_TRUE(results.return_value) << results.error_log;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    SCOPED_TRACE("block " + std::to_string(i));
    expect_near(results.local_jacobians[i], results.local_numeric_jacobians[i], tolerance);
  }
}

}  // namespace imslam::testing

#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>

#include <vector>

#include "pgo/graph_data.hpp"

namespace imslam::pgo {

/// Numbers in the parameter block and degrees of freedom of a kind of block.
int block_size(BlockId::Kind kind);
int tangent_size(BlockId::Kind kind);

/// r = residual + J (x minus X), see MarginalPrior. Blocks as in `prior.blocks`.
class MarginalPriorFactor final : public ceres::CostFunction {
 public:
  explicit MarginalPriorFactor(const MarginalPrior& prior);
  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  MarginalPrior prior_;
};

}  // namespace imslam::pgo

#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "pgo/graph_problem.hpp"

namespace imslam::pgo {

/// Residuals and Jacobian of a graph at its present point, robust kernels applied, with respect to
/// the tangents of the estimated blocks.
struct LinearSystem {
  Eigen::SparseMatrix<double> J;
  Eigen::VectorXd residual;
  std::vector<BlockId> blocks;        ///< columns of J, block by block
  std::vector<Eigen::Index> offsets;  ///< first column of each block; one more: the end

  Eigen::Index columns() const { return offsets.back(); }
};

/// All estimated blocks: state by state [pose velocity bias], then the globals.
std::vector<BlockId> estimated_blocks(GraphProblem& graph, int states);

/// Linearises the whole graph, or only the given residual blocks.
LinearSystem linearize(GraphProblem& graph,
                       const std::vector<BlockId>& blocks,
                       const std::vector<ceres::ResidualBlockId>& residuals = {});

}  // namespace imslam::pgo

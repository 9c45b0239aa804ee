#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "pgo/graph_data.hpp"
#include "pgo/options.hpp"
#include "slam/base/solve_report.hpp"

namespace ceres::internal {
class ResidualBlock;
}

namespace imslam::pgo {

class GraphProblem;

/// Some edges of a graph: one flag for each, in the order of the graph.
struct EdgeSelection {
  std::vector<char> visual;
  std::vector<char> inertial;
};

/// A graph at one point mu of the manifold of its estimated blocks, for those who differentiate.
///
/// The tangent is that of the blocks in a fixed order, state by state [pose velocity bias], then
/// [gravity, disparity offset, focal error, time offset]; what is not estimated has no place in it.
/// A pose moves as T Exp(tau), the direction of gravity on its sphere, all else by addition.
class GraphPoint {
 public:
  GraphPoint(const GraphData& data, const GraphOptions& options);
  ~GraphPoint();
  GraphPoint(const GraphPoint&) = delete;
  GraphPoint& operator=(const GraphPoint&) = delete;

  const std::vector<BlockId>& blocks() const { return blocks_; }
  const std::vector<Eigen::Index>& offsets() const { return offsets_; }  ///< one more: the size
  Eigen::Index size() const { return offsets_.back(); }
  /// First entry of the block in the tangent; -1: it is not estimated.
  Eigen::Index offset(const BlockId& id) const;

  /// Goes to the nearest minimum of the graph's cost.
  SolveReport solve(const SolverOptions& options);
  void move(const Eigen::VectorXd& tau);

  /// The numbers of all estimated blocks (7 for a pose), to come back to a point exactly.
  Eigen::VectorXd numbers() const;
  void set_numbers(const Eigen::VectorXd& numbers);
  /// Writes the states; false and no change if any number is not finite.
  bool store(GraphData& data) const;

  /// Slope of the cost by the tangent, of the whole graph or of some edges.
  Eigen::VectorXd gradient() const;
  Eigen::VectorXd gradient(const EdgeSelection& edges) const;
  /// J^T J, robust kernels counted as their weights.
  Eigen::SparseMatrix<double> gauss_newton_hessian() const;

 private:
  Eigen::VectorXd gradient_of(const std::vector<ceres::internal::ResidualBlock*>& residuals) const;

  std::unique_ptr<GraphProblem> problem_;
  std::vector<BlockId> blocks_;
  std::vector<Eigen::Index> offsets_;
  std::string unsolvable_;
};

}  // namespace imslam::pgo

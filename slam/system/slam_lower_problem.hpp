#pragma once

#include <Eigen/SparseCholesky>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pgo/graph_point.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "slam/learner/lower_problem.hpp"
#include "slam/system/measurement_coordinates.hpp"
#include "slam/system/slam_upper_cost.hpp"

namespace imslam::system {

/// The pose-velocity graph as the lower level: z are its measurements, mu its states.
///
///   L(mu, z) = cost of the graph + sum_edges 1/2 log det Sigma + sum_bias_priors log sigma
///
/// The log-determinants let z hold covariances too: without them they would grow without limit.
///
/// phi of the learner is mu in coordinates y in which the Gauss-Newton Hessian at the last solution
/// is the identity:
///
///   mu = mu* Exp(tau),   tau = P^T C^-T y,   P J^T J P^T = C C^T   (sparse Cholesky)
///
/// Hence dL/dphi is in units of the cost, |dL/dphi|^2 / 2 being what one more step would gain, and
/// H = I + (what Gauss-Newton leaves out): conjugate gradient needs a handful of products. These
/// are exact: central differences (five points) of the analytic gradients along y.
class SlamLowerProblem : public learner::LowerProblem,
                         public learner::StationaryCost,
                         public learner::UpperCost,
                         public learner::FactoredCurvature {
 public:
  using Vector = learner::Vector;

  /// The graph as a run left it, e.g. SlamResult::graph_data: its measurements are the origin of z,
  /// its states the first guess.
  SlamLowerProblem(const pgo::GraphData& data,
                   const pgo::GraphOptions& graph_options,
                   const pgo::SolverOptions& solver_options = {},
                   const SlamUpperOptions& upper_options = {});

  /// How z is laid out, and the way between it and measurements.
  const MeasurementCoordinates& coordinates() const { return coordinates_; }

  /// From the states of the last solve to where |dL/dphi| is down to rounding errors. Not converged
  /// if it is not below 1e-7, or if a covariance in z is not positive: then nothing moves.
  SolveReport solve(const Vector& z) override;
  /// The next solve starts from the first guess: then its result depends on z alone, bit by bit.
  void restart();

  double cost() const override;
  Vector cost_by_z() const override;
  Vector cost_by_phi() const override;

  learner::UpperValue upper_cost() const override;

  Vector hessian_product(const Vector& v) const override;
  Vector mixed_product(const Vector& v) const override;
  /// To a relative residual of 1e-9 or so, as far as the differences go: ask the strategy for a
  /// linear_tolerance of 1e-7. Empty: J^T J is singular, or H not positive.
  std::optional<Vector> hessian_solve(const Vector& v) const override;

  /// The graph at the last solution, with the measurements of its z.
  const pgo::PoseVelocityGraph& graph() const { return graph_; }
  /// The order of the states' tangent tau.
  const pgo::GraphPoint& point() const { return *point_; }

 protected:
  /// Where questions are asked: a cache, moved by steps and differences too.
  std::string set_measurements(const Vector& z) const;  ///< what is wrong with z; empty: fine
  bool take_states() const { return point_->store(graph_.data()); }
  pgo::GraphPoint& movable_point() const { return *point_; }
  const Vector& z() const { return z_; }
  bool factorize();
  Vector tau_of(const Vector& y) const;          ///< P^T C^-T y
  Vector by_phi_of(const Vector& by_tau) const;  ///< C^-1 P dL/dtau
  Vector by_tau_of(const Vector& by_phi) const;  ///< its inverse

 private:
  double descend();
  Vector derivative(const Vector& y, const std::function<Vector()>& f) const;

  MeasurementCoordinates coordinates_;
  pgo::SolverOptions solver_options_;
  SlamUpperOptions upper_options_;
  std::vector<pgo::State> first_states_;
  pgo::Globals first_globals_;
  mutable pgo::PoseVelocityGraph graph_;
  mutable std::unique_ptr<pgo::GraphPoint>
      point_;  ///< at the states of graph_, but within derivative()
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  bool factored_ = false;
  mutable Vector z_;
};

}  // namespace imslam::system

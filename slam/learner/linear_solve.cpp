#include "slam/learner/linear_solve.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace imslam::learner {
namespace {

/// Largest eigenvalue of H >= 0 by power iteration; from below, so the caller leaves a margin.
double largest_eigenvalue(const MatrixProduct& H, const Vector& start) {
  constexpr int kIterations = 50;
  Vector x = start.normalized();
  double value = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const Vector y = H(x);
    value = y.norm();
    if (!(value > 0.0)) return 0.0;
    x = y / value;
  }
  return value;
}

void finish(const MatrixProduct& H,
            const Vector& v,
            double tolerance,
            const char* failure,
            LinearSolution& solution) {
  const double scale = v.norm();
  solution.report.residual = scale > 0.0 ? (H(solution.q) - v).norm() / scale : 0.0;
  solution.report.converged = solution.report.residual <= tolerance;
  if (!solution.report.converged) solution.report.reason = failure;
}

}  // namespace

LinearSolution conjugate_gradient(const MatrixProduct& H,
                                  const Vector& v,
                                  const LinearOptions& options) {
  LinearSolution solution{Vector::Zero(v.size()), {}};
  const char* failure = "conjugate gradient: iterations do not suffice, or H is singular";
  Vector r = v;
  Vector p = r;
  double r_sq = r.squaredNorm();
  // Aims below the tolerance: the residual that counts is computed anew at the end.
  const double goal_sq = std::pow(0.5 * options.tolerance, 2) * r_sq;
  int& iteration = solution.report.iterations;
  for (; iteration < options.iterations && r_sq > goal_sq; ++iteration) {
    const Vector Hp = H(p);
    const double curvature = p.dot(Hp);
    if (!(curvature > 1e-14 * p.norm() * Hp.norm())) {
      failure = "conjugate gradient: H is not positive along the search direction";
      break;
    }
    const double step = r_sq / curvature;
    solution.q += step * p;
    r -= step * Hp;
    const double next_sq = r.squaredNorm();
    p = r + (next_sq / r_sq) * p;
    r_sq = next_sq;
  }
  finish(H, v, options.tolerance, failure, solution);
  return solution;
}

LinearSolution gradient_descent(const MatrixProduct& H,
                                const Vector& v,
                                const LinearOptions& options) {
  LinearSolution solution{Vector::Zero(v.size()), {}};
  double step = options.step;
  if (step <= 0.0) {
    constexpr double kMargin = 1.05;  // power iteration comes from below
    const double largest = largest_eigenvalue(H, v);
    step = largest > 0.0 ? 1.0 / (kMargin * largest) : 0.0;
  }
  const double goal = 0.5 * options.tolerance * v.norm();
  int& iteration = solution.report.iterations;
  for (; iteration < options.iterations; ++iteration) {
    const Vector residual = H(solution.q) - v;
    if (!(residual.norm() > goal)) break;
    solution.q -= step * residual;
  }
  finish(H, v, options.tolerance, "gradient descent: iterations do not suffice, or no minimum",
         solution);
  return solution;
}

LinearSolution least_norm(const Matrix& H, const Vector& v, double tolerance) {
  LinearSolution solution{Vector::Zero(v.size()), {}};
  if (!H.allFinite() || !v.allFinite()) {
    solution.report = {false, 0, 1.0, "direct: the system is not finite"};
    return solution;
  }
  Eigen::CompleteOrthogonalDecomposition<Matrix> factor(H);
  solution.q = factor.solve(v);
  solution.report.iterations = 1;
  const bool singular = factor.rank() < H.rows();
  finish([&H](const Vector& x) -> Vector { return H * x; }, v, tolerance,
         singular ? "direct: singular, and no solution" : "direct: ill-conditioned", solution);
  if (singular && solution.report.converged) {
    solution.report.reason = "singular system: the shortest solution taken";
  }
  return solution;
}

Matrix matrix_of(const MatrixProduct& H, Eigen::Index size) {
  Matrix M(size, size);
  for (Eigen::Index i = 0; i < size; ++i) M.col(i) = H(Vector::Unit(size, i));
  return M;
}

}  // namespace imslam::learner

#pragma once

#include <functional>
#include <string>

#include "slam/learner/lower_problem.hpp"

namespace imslam::learner {

/// How H q = v was solved. `residual` is |H q - v| / |v|, computed anew at the end.
struct LinearSolveReport {
  bool converged = true;
  int iterations = 0;
  double residual = 0.0;
  std::string reason;  ///< why it failed or what it fell back to, for people
};

struct LinearSolution {
  Vector q;
  LinearSolveReport report;
};

using MatrixProduct = std::function<Vector(const Vector&)>;

struct LinearOptions {
  double tolerance = 1e-10;  ///< relative residual
  int iterations = 1000;     ///< at most
  double step = 0.0;         ///< of gradient descent; 0: from the largest eigenvalue
};

/// Conjugate gradient for a symmetric H >= 0. A singular H is fine if v lies in its range: the
/// solution is the shortest. Says so if H curves downwards or the iterations do not suffice.
LinearSolution conjugate_gradient(const MatrixProduct& H,
                                  const Vector& v,
                                  const LinearOptions& options);

/// q <- q - step (H q - v), H >= 0. Stopped early this is a truncated Neumann series.
LinearSolution gradient_descent(const MatrixProduct& H,
                                const Vector& v,
                                const LinearOptions& options);

/// The shortest least-squares solution; singular systems are solved and reported as such.
LinearSolution least_norm(const Matrix& H, const Vector& v, double tolerance);

/// H, column by column.
Matrix matrix_of(const MatrixProduct& H, Eigen::Index size);

}  // namespace imslam::learner

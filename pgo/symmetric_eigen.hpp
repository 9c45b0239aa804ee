#pragma once

#include <Eigen/Core>

namespace imslam::pgo {

/// S = vectors diag(values) vectors^T, values in rising order, vectors orthonormal.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Of a symmetric matrix; reads the lower triangle. One unit for all sizes: the decomposition of
/// fixed 6 x 6 and 9 x 9 matrices alone takes a compiler half a minute.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& S);

}  // namespace imslam::pgo

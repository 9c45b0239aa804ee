#include "pgo/symmetric_eigen.hpp"

#include <Eigen/Eigenvalues>

namespace imslam::pgo {

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& S) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(S);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

}  // namespace imslam::pgo

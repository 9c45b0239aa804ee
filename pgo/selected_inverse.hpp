#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <optional>

namespace imslam::pgo {

/// Chosen entries of the inverse of a sparse positive definite matrix, without forming the rest.
///
/// From H = L D L^T follows  Z = D^-1 L^-1 + (I - L^T) Z  for Z = H^-1, which gives the entries of
/// Z on the pattern of L, last column first, from each other. On a chain that is linear in its
/// length. Source: Takahashi, Fagan, Chin, "Formation of a sparse bus impedance matrix", 1973.
class SelectedInverse {
 public:
  /// Empty if H is not positive definite to working precision.
  static std::optional<SelectedInverse> factorize(const Eigen::SparseMatrix<double>& H);

  /// Entry of H^-1 where H itself (or its Cholesky factor) has an entry, explicit zeros included.
  double operator()(Eigen::Index row, Eigen::Index column) const;

  double log_determinant() const { return log_determinant_; }  ///< of H

 private:
  void invert(const Eigen::SparseMatrix<double>& L, const Eigen::VectorXd& D);

  Eigen::VectorXd scale_;              ///< H was scaled to a unit diagonal
  Eigen::VectorXi position_;           ///< place of each unknown in the elimination order
  Eigen::SparseMatrix<double> lower_;  ///< strictly lower part of Z, permuted, on L's pattern
  Eigen::VectorXd diagonal_;
  double log_determinant_ = 0.0;
};

}  // namespace imslam::pgo

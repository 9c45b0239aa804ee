#include "pgo/whitening.hpp"

#include <Eigen/Cholesky>

#include "pgo/symmetric_eigen.hpp"

namespace imslam::pgo {

std::optional<Eigen::MatrixXd> sqrt_information(const Eigen::MatrixXd& covariance) {
  const double scale = covariance.cwiseAbs().maxCoeff();
  if (!covariance.allFinite() || !(covariance.diagonal().minCoeff() > 0.0)) return std::nullopt;
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale) {
    return std::nullopt;
  }

  // Units are mixed (m, rad, m/s): judge the rank on the correlation matrix.
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse_sigma = sigma.cwiseInverse();
  Eigen::MatrixXd correlation =
      inverse_sigma.asDiagonal() * covariance * inverse_sigma.asDiagonal();
  correlation = 0.5 * (correlation + correlation.transpose()).eval();
  Eigen::LLT<Eigen::MatrixXd> llt(correlation);
  const double smallest_pivot =
      llt.info() == Eigen::Success ? Eigen::MatrixXd(llt.matrixL()).diagonal().minCoeff() : 0.0;
  if (smallest_pivot * smallest_pivot < kSmallestCorrelation) {
    const SymmetricEigen eigen = symmetric_eigen(correlation);
    const Eigen::VectorXd floored = eigen.values.cwiseMax(kSmallestCorrelation);
    correlation = eigen.vectors * floored.asDiagonal() * eigen.vectors.transpose();
    llt.compute(correlation);
    if (llt.info() != Eigen::Success) return std::nullopt;
  }

  const Eigen::Index size = covariance.rows();
  Eigen::MatrixXd W = llt.matrixL().solve(Eigen::MatrixXd::Identity(size, size));
  W = W * inverse_sigma.asDiagonal();
  if (!W.allFinite()) return std::nullopt;
  return W;
}

}  // namespace imslam::pgo

#pragma once

#include <Eigen/Core>
#include <optional>

namespace imslam::pgo {

/// Smallest eigenvalue that is left to the correlation matrix of a measurement. An interval with a
/// single IMU sample has a singular covariance (dp = dv dt / 2 exactly); it must not become an
/// infinite weight.
inline constexpr double kSmallestCorrelation = 1e-9;

/// Lower triangular W with W^T W = covariance^-1, so that |W e|^2 is the squared Mahalanobis norm.
/// Empty if the matrix is not finite, not symmetric or has a diagonal entry that is not positive.
std::optional<Eigen::MatrixXd> sqrt_information(const Eigen::MatrixXd& covariance);

}  // namespace imslam::pgo

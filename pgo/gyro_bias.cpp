#include "pgo/gyro_bias.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace imslam::pgo {
namespace {

constexpr int kRounds = 8;
constexpr double kHuberWidth = 3.0;  // standard deviations

}  // namespace

Eigen::Vector3d fit_gyro_bias(const std::vector<RelativeMotion>& visual,
                              const std::vector<ImuMotion>& inertial,
                              double rotation_floor) {
  using Eigen::Matrix3d;
  using Eigen::Vector3d;
  using lie::SO3d;
  Vector3d bias = Vector3d::Zero();
  for (const ImuMotion& motion : inertial) {
    if (motion.valid) bias = motion.bias.gyro;
  }
  for (int round = 0; round < kRounds; ++round) {
    Matrix3d H = Matrix3d::Identity() * 1e-12;
    Vector3d g = Vector3d::Zero();
    for (std::size_t i = 0; i < visual.size(); ++i) {
      if (!visual[i].valid || !inertial[i].valid) continue;
      const Matrix3d J_x_bias = inertial[i].J_dR_bias.leftCols<3>();
      const Vector3d x = J_x_bias * (bias - inertial[i].bias.gyro);
      const SO3d dR = inertial[i].dR * SO3d::exp(x);
      const Vector3d r = (dR.inverse() * visual[i].T_body0_body1.rotation()).log();
      const Matrix3d J = -SO3d::left_jacobian_inverse(r) * SO3d::right_jacobian(x) * J_x_bias;
      const Matrix3d covariance = visual[i].covariance.bottomRightCorner<3, 3>() +
                                  inertial[i].covariance.topLeftCorner<3, 3>() +
                                  rotation_floor * rotation_floor * Matrix3d::Identity();
      const Eigen::LLT<Matrix3d> llt(covariance);
      if (llt.info() != Eigen::Success || !r.allFinite()) continue;
      const double size = llt.matrixL().solve(r).norm();
      const double weight = size > kHuberWidth ? kHuberWidth / size : 1.0;
      H += weight * J.transpose() * llt.solve(J);
      g += weight * J.transpose() * llt.solve(r);
    }
    const Vector3d step = -H.ldlt().solve(g);
    if (!step.allFinite()) break;
    bias += step;
    if (step.norm() < 1e-12) break;
  }
  return bias;
}

}  // namespace imslam::pgo

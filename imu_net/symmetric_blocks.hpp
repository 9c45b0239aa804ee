#pragma once

#include <Eigen/Core>

namespace imslam::imu {

/// A symmetric 9x9 matrix over [dR dv dp]: its 3x3 blocks on and below the diagonal.
struct SymmetricBlocks {
  using Matrix9d = Eigen::Matrix<double, 9, 9>;

  Eigen::Matrix3d RR = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d vR = Eigen::Matrix3d::Zero(), vv = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d pR = Eigen::Matrix3d::Zero(), pv = Eigen::Matrix3d::Zero(),
                  pp = Eigen::Matrix3d::Zero();

  SymmetricBlocks() = default;
  /// The symmetric part of X.
  explicit SymmetricBlocks(const Matrix9d& X) { *this += X; }

  SymmetricBlocks& operator+=(const Matrix9d& X) {
    const Matrix9d S = 0.5 * (X + X.transpose());
    RR += S.block<3, 3>(0, 0);
    vR += S.block<3, 3>(3, 0);
    vv += S.block<3, 3>(3, 3);
    pR += S.block<3, 3>(6, 0);
    pv += S.block<3, 3>(6, 3);
    pp += S.block<3, 3>(6, 6);
    return *this;
  }

  Matrix9d matrix() const {
    Matrix9d S;
    S << RR, vR.transpose(), pR.transpose(), vR, vv, pv.transpose(), pR, pv, pp;
    return 0.5 * (S + S.transpose());
  }
};

}  // namespace imslam::imu

#pragma once

#include <ceres/manifold.h>

#include "slam/lie/se3.hpp"

namespace imslam::pgo {

/// The only place that knows how a pose lies in a Ceres parameter block: [tx ty tz qx qy qz qw].
inline constexpr int kPoseSize = 7;
inline constexpr int kPoseTangentSize = 6;

template <typename T>
lie::SE3<T> pose_from_block(const T* block) {
  const Eigen::Map<const Eigen::Matrix<T, 3, 1>> translation(block);
  const Eigen::Map<const Eigen::Quaternion<T>> rotation(block + 3);
  return {lie::SO3<T>(rotation), translation};
}

template <typename T>
void pose_to_block(const lie::SE3<T>& pose, T* block) {
  Eigen::Map<Eigen::Matrix<T, 3, 1>> translation(block);
  Eigen::Map<Eigen::Quaternion<T>> rotation(block + 3);
  translation = pose.translation();
  rotation = pose.rotation().quaternion();
}

using PosePlusJacobian = Eigen::Matrix<double, kPoseSize, kPoseTangentSize, Eigen::RowMajor>;
using PoseMinusJacobian = Eigen::Matrix<double, kPoseTangentSize, kPoseSize, Eigen::RowMajor>;

/// d block(X Exp(tau)) / d tau at tau = 0.
PosePlusJacobian pose_plus_jacobian(const double* block);

/// d Log(X^-1 Y) / d block(Y) at Y = X; a left inverse of pose_plus_jacobian.
PoseMinusJacobian pose_minus_jacobian(const double* block);

/// Hands a Jacobian with respect to the tangent to Ceres, which wants it with respect to the seven
/// numbers of the block and multiplies by the plus Jacobian afterwards:  J_block = J_tau J_minus.
template <typename Derived>
void pose_jacobian_to_block(const Eigen::MatrixBase<Derived>& J_tau,
                            const double* block,
                            double* J_block) {
  constexpr int kRows = Derived::RowsAtCompileTime;
  Eigen::Map<Eigen::Matrix<double, kRows, kPoseSize, Eigen::RowMajor>> J(J_block, J_tau.rows(),
                                                                         kPoseSize);
  const PoseMinusJacobian J_minus = pose_minus_jacobian(block);
  J.template leftCols<3>().noalias() = J_tau.template leftCols<3>() * J_minus.topLeftCorner<3, 3>();
  J.template rightCols<4>().noalias() =
      J_tau.template rightCols<3>() * J_minus.bottomRightCorner<3, 4>();
}

/// The house plus and minus, X Exp(tau) and Log(X^-1 Y), in the words of Ceres.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return kPoseTangentSize; }
  bool Plus(const double* x, const double* tau, double* x_plus_tau) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

}  // namespace imslam::pgo

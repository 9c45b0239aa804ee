#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace imslam::evaluation {

/// Algebra of 4x4 poses that are used exactly as a file gives them: KITTI matrices are orthonormal
/// to seven digits only, and making them so would change the figures.

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegreesPerRadian = 180.0 / kPi;

inline Eigen::Vector3d position(const Eigen::Matrix4d& T) { return T.topRightCorner<3, 1>(); }
inline Eigen::Matrix3d rotation(const Eigen::Matrix4d& T) { return T.topLeftCorner<3, 3>(); }

inline Eigen::Matrix4d rigid(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = R;
  T.topRightCorner<3, 1>() = t;
  return T;
}

/// [R^T, -R^T t]: transposes, as evo does, where R is not quite orthonormal.
inline Eigen::Matrix4d rigid_inverse(const Eigen::Matrix4d& T) {
  const Eigen::Matrix3d R_transposed = rotation(T).transpose();
  return rigid(R_transposed, -(R_transposed * position(T)));
}

/// A^-1 B.
inline Eigen::Matrix4d relative_pose(const Eigen::Matrix4d& A, const Eigen::Matrix4d& B) {
  return rigid_inverse(A) * B;
}

/// Unit quaternion of a nearly orthonormal R by Shepperd's method: the largest of the four
/// components is computed first, so that no digits are lost near half turns.
inline Eigen::Quaterniond quaternion_of(const Eigen::Matrix3d& R) {
  const double trace = R.trace();
  int largest = 0;
  const double diagonal = R.diagonal().maxCoeff(&largest);
  Eigen::Quaterniond q;
  if (trace >= diagonal) {
    q = {1.0 + trace, R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1)};
  } else {
    const int i = largest;
    const int j = (i + 1) % 3;
    const int k = (j + 1) % 3;
    q.coeffs()(i) = 1.0 - trace + 2.0 * R(i, i);
    q.coeffs()(j) = R(j, i) + R(i, j);
    q.coeffs()(k) = R(k, i) + R(i, k);
    q.w() = R(k, j) - R(j, k);
  }
  return q.normalized();
}

/// || log R || in [0, pi] [rad].
inline double rotation_angle(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q = quaternion_of(R);
  return 2.0 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

/// Largest of |R^T R - I| and |det R - 1|: how far R is from being a rotation.
inline double rotation_defect(const Eigen::Matrix3d& R) {
  const double skewness = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  return std::max(skewness, std::abs(R.determinant() - 1.0));
}

}  // namespace imslam::evaluation

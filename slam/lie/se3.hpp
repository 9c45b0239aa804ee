#pragma once

#include <Eigen/Core>

#include "slam/lie/so3.hpp"

namespace imslam::lie {

/// Rigid motion in 3D. T_a_b carries points from frame b to frame a:  p_a = T_a_b * p_b.
///
///   storage   [tx ty tz qx qy qz qw], unit quaternion (Hamilton)
///   tangent   [rho theta] in [m, rad], translation first
///   plus      X + tau := X * Exp(tau); all Jacobians here are with respect to this right tau
template <typename Scalar>
class SE3 {
 public:
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
  using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;
  using Matrix4 = Eigen::Matrix<Scalar, 4, 4>;
  using Tangent = Eigen::Matrix<Scalar, 6, 1>;
  using Matrix6 = Eigen::Matrix<Scalar, 6, 6>;
  using PointJacobian = Eigen::Matrix<Scalar, 3, 6>;

  SE3() : translation_(Vector3::Zero()) {}
  SE3(const SO3<Scalar>& rotation, const Vector3& translation)
      : rotation_(rotation), translation_(translation) {}

  /// Last row is taken as [0 0 0 1]; the rotation is made orthonormal.
  static SE3 from_matrix(const Matrix4& M) {
    return SE3(SO3<Scalar>::from_matrix(M.template topLeftCorner<3, 3>()),
               M.template topRightCorner<3, 1>());
  }

  static SE3 exp(const Tangent& tau) {
    const Vector3 rho = tau.template head<3>();
    const Vector3 theta = tau.template tail<3>();
    return SE3(SO3<Scalar>::exp(theta), SO3<Scalar>::left_jacobian(theta) * rho);
  }

  Tangent log() const {
    const Vector3 theta = rotation_.log();
    Tangent tau;
    tau << SO3<Scalar>::left_jacobian_inverse(theta) * translation_, theta;
    return tau;
  }

  SE3 inverse() const {
    const SO3<Scalar> R_inverse = rotation_.inverse();
    return SE3(R_inverse, -(R_inverse * translation_));
  }

  SE3 operator*(const SE3& other) const {
    return SE3(rotation_ * other.rotation_, translation_ + rotation_ * other.translation_);
  }

  /// Moves a point and, if asked, differentiates the result.
  Vector3 act(const Vector3& p, PointJacobian* J_y_X = nullptr) const {
    if (J_y_X != nullptr) *J_y_X << rotation_.matrix(), -rotation_.matrix() * skew(p);
    return rotation_ * p + translation_;
  }
  Vector3 operator*(const Vector3& p) const { return act(p); }

  /// X * Exp(tau) = Exp(Ad_X tau) * X.
  Matrix6 adjoint() const {
    const Matrix3 R = rotation_.matrix();
    Matrix6 A;
    A << R, skew(translation_) * R, Matrix3::Zero(), R;
    return A;
  }

  /// Exp(tau + d) = Exp(J_l d) Exp(tau).
  static Matrix6 left_jacobian(const Tangent& tau) {
    const Matrix3 J = SO3<Scalar>::left_jacobian(tau.template tail<3>());
    Matrix6 result;
    result << J, left_jacobian_coupling(tau), Matrix3::Zero(), J;
    return result;
  }

  static Matrix6 left_jacobian_inverse(const Tangent& tau) {
    const Matrix3 J_inverse = SO3<Scalar>::left_jacobian_inverse(tau.template tail<3>());
    Matrix6 result;
    result << J_inverse, -J_inverse * left_jacobian_coupling(tau) * J_inverse, Matrix3::Zero(),
        J_inverse;
    return result;
  }

  static Matrix6 right_jacobian(const Tangent& tau) { return left_jacobian(-tau); }
  static Matrix6 right_jacobian_inverse(const Tangent& tau) { return left_jacobian_inverse(-tau); }

  Matrix4 matrix() const {
    Matrix4 M = Matrix4::Identity();
    M.template topLeftCorner<3, 3>() = rotation_.matrix();
    M.template topRightCorner<3, 1>() = translation_;
    return M;
  }

  template <typename Other>
  SE3<Other> cast() const {
    return SE3<Other>(rotation_.template cast<Other>(), translation_.template cast<Other>());
  }

  const SO3<Scalar>& rotation() const { return rotation_; }
  const Vector3& translation() const { return translation_; }

 private:
  /// Upper right block Q(rho, theta) of the left Jacobian.
  /// Barfoot, "State Estimation for Robotics", 2017, eq. (7.86); its series for small angles.
  static Matrix3 left_jacobian_coupling(const Tangent& tau) {
    using std::cos, std::sin, std::sqrt;
    const Matrix3 P = skew(tau.template head<3>());
    const Matrix3 K = skew(tau.template tail<3>());
    const Scalar angle_sq = tau.template tail<3>().squaredNorm();
    // The closed forms lose digits earlier than those of SO(3): they divide by angle^5.
    Scalar a = Scalar(1.0 / 6.0) - angle_sq / Scalar(120) + angle_sq * angle_sq / Scalar(5040);
    Scalar b = Scalar(1.0 / 24.0) - angle_sq / Scalar(720) + angle_sq * angle_sq / Scalar(40320);
    Scalar c = Scalar(1.0 / 120.0) - angle_sq / Scalar(2520) + angle_sq * angle_sq / Scalar(120960);
    if (angle_sq > Scalar(1e-2)) {
      const Scalar angle = sqrt(angle_sq);
      a = (angle - sin(angle)) / (angle_sq * angle);
      b = (angle_sq / Scalar(2) + cos(angle) - Scalar(1)) / (angle_sq * angle_sq);
      c = (Scalar(2) * angle - Scalar(3) * sin(angle) + angle * cos(angle)) /
          (Scalar(2) * angle_sq * angle_sq * angle);
    }
    const Matrix3 PK = P * K;
    const Matrix3 KP = K * P;
    return P / Scalar(2) + a * (KP + PK + K * PK) + b * (K * KP + PK * K - Scalar(3) * K * PK) +
           c * (K * PK * K + K * KP * K);
  }

  SO3<Scalar> rotation_;
  Vector3 translation_;
};

using SE3d = SE3<double>;
using SE3f = SE3<float>;

}  // namespace imslam::lie

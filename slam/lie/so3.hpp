#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "slam/lie/so3_coefficients.hpp"

namespace imslam::lie {

/// Below this squared angle [rad^2] closed forms are replaced by their Taylor series.
inline constexpr double kSmallAngleSquared = 1e-8;

/// Enough for matrices far from orthonormal; those at hand need two.
inline constexpr int kPolarIterations = 30;

template <typename Derived>
Eigen::Matrix<typename Derived::Scalar, 3, 3> skew(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  Eigen::Matrix<Scalar, 3, 3> S;
  S << Scalar(0), -v.z(), v.y(), v.z(), Scalar(0), -v.x(), -v.y(), v.x(), Scalar(0);
  return S;
}

/// The vector d . axial(X) = <X, [d]x> for every d.
template <typename Derived>
Eigen::Matrix<typename Derived::Scalar, 3, 1> axial(const Eigen::MatrixBase<Derived>& X) {
  const Eigen::Matrix<typename Derived::Scalar, 3, 3> M = X;  // X may be a product
  return {M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1)};
}

/// Rotation in 3D. Tangent: rotation vector theta [rad]; plus: R Exp(theta).
///
///   left Jacobian    Exp(theta + d) = Exp(J_l d) Exp(theta)
///   right Jacobian   Exp(theta + d) = Exp(theta) Exp(J_r d),   J_r(theta) = J_l(-theta)
///
/// Source of the closed forms: Sola, Deray, Atchuthan, "A micro Lie theory", 2018, appendix B.
template <typename Scalar>
class SO3 {
 public:
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
  using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;
  using Quaternion = Eigen::Quaternion<Scalar>;

  SO3() : q_(Quaternion::Identity()) {}
  explicit SO3(const Quaternion& q) : q_(q.normalized()) {}

  /// The rotation nearest to M in the Frobenius norm; M needs not be orthonormal, but det(M) > 0.
  static SO3 from_matrix(const Matrix3& M) {
    using std::sqrt;
    // Newton-Schulz iteration for the polar factor; it converges from singular values below
    // sqrt(3), which the scaling ensures. Higham, "Functions of Matrices", 2008, section 8.3.
    const Scalar norm_sq = M.squaredNorm();
    if (!(norm_sq > Scalar(0))) return SO3();
    Matrix3 R = M * sqrt(Scalar(3) / norm_sq);
    for (int i = 0; i < kPolarIterations; ++i) {
      const Matrix3 excess = R.transpose() * R - Matrix3::Identity();
      R -= Scalar(0.5) * R * excess;
      if (excess.squaredNorm() < Scalar(1e-20)) break;  // the step just taken squared it
    }
    return SO3(Quaternion(R));
  }

  static SO3 exp(const Vector3& theta) {
    using std::cos, std::sin, std::sqrt;
    const Scalar angle_sq = theta.squaredNorm();
    Scalar real = Scalar(1) - angle_sq / Scalar(8);
    Scalar imag = Scalar(0.5) - angle_sq / Scalar(48);
    if (angle_sq > Scalar(kSmallAngleSquared)) {
      const Scalar angle = sqrt(angle_sq);
      real = cos(angle / Scalar(2));
      imag = sin(angle / Scalar(2)) / angle;
    }
    return SO3(Quaternion(real, imag * theta.x(), imag * theta.y(), imag * theta.z()));
  }

  Vector3 log() const {
    using std::atan2, std::sqrt;
    const Scalar sign = q_.w() < Scalar(0) ? Scalar(-1) : Scalar(1);  // q and -q: the same rotation
    const Scalar w = sign * q_.w();
    const Scalar n_sq = q_.vec().squaredNorm();
    if (n_sq < Scalar(kSmallAngleSquared)) {
      return sign * (Scalar(2) / w) * (Scalar(1) - n_sq / (Scalar(3) * w * w)) * q_.vec();
    }
    const Scalar n = sqrt(n_sq);
    return sign * (Scalar(2) * atan2(n, w) / n) * q_.vec();
  }

  SO3 inverse() const { return SO3(q_.conjugate()); }
  SO3 operator*(const SO3& other) const { return SO3(q_ * other.q_); }
  Vector3 operator*(const Vector3& p) const { return q_ * p; }

  Matrix3 matrix() const { return q_.toRotationMatrix(); }
  const Quaternion& quaternion() const { return q_; }

  template <typename Other>
  SO3<Other> cast() const {
    return SO3<Other>(q_.template cast<Other>());
  }

  /// V(theta) = integral of Exp(s theta) ds over [0, 1].
  static Matrix3 left_jacobian(const Vector3& theta) { return right_jacobian(-theta); }

  static Matrix3 left_jacobian_inverse(const Vector3& theta) {
    using std::cos, std::sin, std::sqrt;
    const Scalar angle_sq = theta.squaredNorm();
    Scalar c = Scalar(1.0 / 12.0) + angle_sq / Scalar(720);
    if (angle_sq > Scalar(kSmallAngleSquared)) {
      // (1 + cos)/(2 angle sin) = cot(angle/2)/(2 angle): stays exact at a half turn.
      const Scalar half = sqrt(angle_sq) / Scalar(2);
      c = (Scalar(1) - half * cos(half) / sin(half)) / angle_sq;
    }
    const Matrix3 K = skew(theta);
    return Matrix3::Identity() - Scalar(0.5) * K + c * K * K;
  }

  static Matrix3 right_jacobian(const Vector3& theta) {
    const Scalar angle_sq = theta.squaredNorm();
    const SO3Coefficients<Scalar> c = so3_coefficients(angle_sq);
    const Vector3 a = c.alpha * theta;
    Matrix3 J = (c.beta * theta) * theta.transpose();
    J.diagonal().array() += Scalar(1) - c.beta * angle_sq;
    J(0, 1) += a.z();
    J(1, 0) -= a.z();
    J(2, 0) += a.y();
    J(0, 2) -= a.y();
    J(1, 2) += a.x();
    J(2, 1) -= a.x();
    return J;
  }

  static Matrix3 right_jacobian_inverse(const Vector3& theta) {
    return left_jacobian_inverse(-theta);
  }

  /// dL/dtheta, where D = dL/dJ_r(theta).
  static Vector3 right_jacobian_gradient(const Vector3& theta, const Matrix3& D) {
    const Scalar angle_sq = theta.squaredNorm();
    const SO3Coefficients<Scalar> c = so3_coefficients(angle_sq);
    const SO3Coefficients<Scalar> slope = so3_coefficient_slopes(angle_sq, c);
    // [a]x [b]x = b a^T - (a . b) I turns every product of two skew matrices into vectors.
    const Vector3 D_axial = axial(D);
    const Vector3 D_theta = D * theta;
    const Scalar trace = D.trace();
    const Scalar along = slope.beta * (theta.dot(D_theta) - angle_sq * trace) -
                         slope.alpha * theta.dot(D_axial) - Scalar(2) * c.beta * trace;
    return along * theta - c.alpha * D_axial + c.beta * (D_theta + D.transpose() * theta);
  }

 private:
  Quaternion q_;
};

using SO3d = SO3<double>;
using SO3f = SO3<float>;

}  // namespace imslam::lie

#include "imu_net/right_jacobian.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace imslam::imu {
namespace {

struct Coefficients {
  double alpha, beta;
};

/// Below this squared angle the closed forms lose digits and the series are exact to rounding.
constexpr double kSeriesAngleSquared = 0.1;

/// c0 - x (c1 - x (c2 - ...)).
double alternating(double x, const std::array<double, 6>& c) {
  double sum = c[5];
  for (std::size_t i = 5; i-- > 0;) sum = c[i] - x * sum;
  return sum;
}

// The coefficients are 1 / (2k + 2)!, 1 / (2k + 3)!, and those times 2k, one further on.
constexpr std::array<double, 6> kAlpha{1.0 / 2,     1.0 / 24,      1.0 / 720,
                                       1.0 / 40320, 1.0 / 3628800, 1.0 / 479001600};
constexpr std::array<double, 6> kBeta{1.0 / 6,      1.0 / 120,      1.0 / 5040,
                                      1.0 / 362880, 1.0 / 39916800, 1.0 / 6227020800};
constexpr std::array<double, 6> kAlphaSlope{1.0 / 12,     1.0 / 180,      1.0 / 6720,
                                            1.0 / 453600, 1.0 / 47900160, 1.0 / 7264857600};
constexpr std::array<double, 6> kBetaSlope{1.0 / 60,      1.0 / 1260,      1.0 / 60480,
                                           1.0 / 4989600, 1.0 / 622702080, 1.0 / 108972864000};

Coefficients coefficients(double x) {  // x = t^2
  if (x < kSeriesAngleSquared) return {alternating(x, kAlpha), alternating(x, kBeta)};
  const double t = std::sqrt(x);
  return {(1.0 - std::cos(t)) / x, (t - std::sin(t)) / (x * t)};
}

/// Their derivatives by t, divided by t.
Coefficients slopes(double x, const Coefficients& c) {
  if (x < kSeriesAngleSquared) return {-alternating(x, kAlphaSlope), -alternating(x, kBetaSlope)};
  return {(1.0 - c.beta * x - 2.0 * c.alpha) / x, (c.alpha - 3.0 * c.beta) / x};
}

}  // namespace

Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& w) {
  const double x = w.squaredNorm();
  const Coefficients c = coefficients(x);
  const Eigen::Vector3d a = c.alpha * w;
  Eigen::Matrix3d J = (c.beta * w) * w.transpose();
  J.diagonal().array() += 1.0 - c.beta * x;
  J(0, 1) += a.z();
  J(1, 0) -= a.z();
  J(2, 0) += a.y();
  J(0, 2) -= a.y();
  J(1, 2) += a.x();
  J(2, 1) -= a.x();
  return J;
}

Eigen::Vector3d right_jacobian_gradient(const Eigen::Vector3d& w, const Eigen::Matrix3d& D) {
  const double x = w.squaredNorm();
  const Coefficients c = coefficients(x);
  const Coefficients slope = slopes(x, c);
  // [a]x [b]x = b a^T - (a . b) I turns every product of two skew matrices into vectors.
  const Eigen::Vector3d D_axial = axial(D);
  const Eigen::Vector3d D_w = D * w;
  const double trace = D.trace();
  const double along =
      slope.beta * (w.dot(D_w) - x * trace) - slope.alpha * w.dot(D_axial) - 2.0 * c.beta * trace;
  return along * w - c.alpha * D_axial + c.beta * (D_w + D.transpose() * w);
}

}  // namespace imslam::imu

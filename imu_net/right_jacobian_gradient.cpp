#include "imu_net/right_jacobian_gradient.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace imslam::imu {
namespace {

/// alpha and beta, and their derivatives by t, divided by t.
struct Coefficients {
  double alpha, beta, alpha_slope, beta_slope;
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
  if (x < kSeriesAngleSquared) {
    return {alternating(x, kAlpha), alternating(x, kBeta), -alternating(x, kAlphaSlope),
            -alternating(x, kBetaSlope)};
  }
  const double t = std::sqrt(x);
  const double alpha = (1.0 - std::cos(t)) / x;
  const double beta = (t - std::sin(t)) / (x * t);
  return {alpha, beta, (std::sin(t) / t - 2.0 * alpha) / x, (alpha - 3.0 * beta) / x};
}

}  // namespace

Eigen::Vector3d right_jacobian_gradient(const Eigen::Vector3d& w, const Eigen::Matrix3d& D) {
  const double angle_sq = w.squaredNorm();
  const Coefficients c = coefficients(angle_sq);
  // [a]x [b]x = b a^T - (a . b) I turns every product of two skew matrices into vectors.
  const Eigen::Vector3d D_axial = axial(D);
  const Eigen::Vector3d D_w = D * w;
  const double trace = D.trace();
  const double along = c.beta_slope * (w.dot(D_w) - angle_sq * trace) -
                       c.alpha_slope * w.dot(D_axial) - 2.0 * c.beta * trace;
  return along * w - c.alpha * D_axial + c.beta * (D_w + D.transpose() * w);
}

}  // namespace imslam::imu

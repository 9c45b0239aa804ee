#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace imslam::lie {

/// Below this squared angle [rad^2] the closed forms of the coefficients lose digits and the series
/// are exact to rounding; they also spare the trigonometry for steps of an integration.
inline constexpr double kSeriesAngleSquared = 0.1;

/// Of the Jacobians of SO3 at a rotation vector of length t:
///
///   J_l = I + alpha [theta]x + beta [theta]x^2,   alpha = (1 - cos t) / t^2,  beta = (t - sin t) /
///   t^3
template <typename Scalar>
struct SO3Coefficients {
  Scalar alpha, beta;
};

/// c0 - x (c1 - x (c2 - ...)).
template <typename Scalar>
Scalar alternating_series(Scalar x, const std::array<double, 6>& c) {
  auto sum = static_cast<Scalar>(c[5]);
  for (std::size_t i = 5; i-- > 0;) sum = static_cast<Scalar>(c[i]) - x * sum;
  return sum;
}

/// `x`: the squared angle [rad^2].
template <typename Scalar>
SO3Coefficients<Scalar> so3_coefficients(Scalar x) {
  // 1 / (2k + 2)! and 1 / (2k + 3)!
  constexpr std::array<double, 6> kAlpha{1.0 / 2,     1.0 / 24,      1.0 / 720,
                                         1.0 / 40320, 1.0 / 3628800, 1.0 / 479001600};
  constexpr std::array<double, 6> kBeta{1.0 / 6,      1.0 / 120,      1.0 / 5040,
                                        1.0 / 362880, 1.0 / 39916800, 1.0 / 6227020800};
  if (x < Scalar(kSeriesAngleSquared)) {
    return {alternating_series(x, kAlpha), alternating_series(x, kBeta)};
  }
  using std::cos, std::sin, std::sqrt;
  const Scalar t = sqrt(x);
  return {(Scalar(1) - cos(t)) / x, (t - sin(t)) / (x * t)};
}

/// d alpha / dt / t and d beta / dt / t.
template <typename Scalar>
SO3Coefficients<Scalar> so3_coefficient_slopes(Scalar x, const SO3Coefficients<Scalar>& c) {
  // Those of the coefficients times 2k, one further on.
  constexpr std::array<double, 6> kAlpha{1.0 / 12,     1.0 / 180,      1.0 / 6720,
                                         1.0 / 453600, 1.0 / 47900160, 1.0 / 7264857600};
  constexpr std::array<double, 6> kBeta{1.0 / 60,      1.0 / 1260,      1.0 / 60480,
                                        1.0 / 4989600, 1.0 / 622702080, 1.0 / 108972864000};
  if (x < Scalar(kSeriesAngleSquared)) {
    return {-alternating_series(x, kAlpha), -alternating_series(x, kBeta)};
  }
  return {(Scalar(1) - c.beta * x - Scalar(2) * c.alpha) / x, (c.alpha - Scalar(3) * c.beta) / x};
}

}  // namespace imslam::lie

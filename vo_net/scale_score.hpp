#pragma once

#include <array>
#include <cmath>

#include "slam/lie/so3.hpp"
#include "slam/nn/dual.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/correspondence.hpp"

namespace imslam::vo::detail {

/// The numbers that one point's share of the scale's equation depends on, in this order.
enum ScaleInput : std::size_t {
  kScale,
  kTurnX,  ///< right tangent of R_left0_left1, 0 at the evaluation
  kTurnY,
  kTurnZ,
  kDirectionX,
  kDirectionY,
  kDirectionZ,
  kLeft0U,
  kLeft0V,
  kLeft1U,
  kLeft1V,
  kDisparity,
  kInformationUU,
  kInformationUV,
  kInformationVV,
  kDisparityInformation,
  kWeight,
  kScaleInputs
};

template <typename T>
using ScaleInputs = std::array<T, kScaleInputs>;

/// What all points share.
struct ScaleView {
  const StereoCamera& camera;
  Eigen::Matrix3d R_left1_left0;
  double kernel_square;  ///< (kernel width * noise scale)^2
};

/// One point at one scale.
template <typename T>
struct ScalePoint {
  bool in_front = false;            ///< false: the rest is not to be used
  std::array<T, 2> e;               ///< [px]
  std::array<T, 2> slope;           ///< de/ds [px/m]
  std::array<T, 2> weighted_slope;  ///< Omega de/ds
  T square;                         ///< e^T Omega e
};

/// Omega a = Lambda a - Lambda g (g^T Lambda a) / (lambda + g^T Lambda g)
template <typename T>
std::array<T, 2> apply_scale_information(const ScaleInputs<T>& x,
                                         const std::array<T, 2>& g,
                                         const std::array<T, 2>& a) {
  const auto flow = [&x](const std::array<T, 2>& v) {
    return std::array<T, 2>{x[kInformationUU] * v[0] + x[kInformationUV] * v[1],
                            x[kInformationUV] * v[0] + x[kInformationVV] * v[1]};
  };
  const std::array<T, 2> La = flow(a);
  const std::array<T, 2> Lg = flow(g);
  const T share =
      (g[0] * La[0] + g[1] * La[1]) / (x[kDisparityInformation] + g[0] * Lg[0] + g[1] * Lg[1]);
  return {La[0] - Lg[0] * share, La[1] - Lg[1] * share};
}

template <typename T>
ScalePoint<T> evaluate_scale_point(const ScaleView& view, const ScaleInputs<T>& x) {
  using Vector = std::array<T, 3>;
  const StereoCamera& c = view.camera;
  // R_left1_left0 for R_left0_left1 Exp(turn), exact to first order at turn = 0.
  const auto turned = [&](const Vector& v) {
    Vector r;
    for (int i = 0; i < 3; ++i) {
      r[static_cast<std::size_t>(i)] = T(view.R_left1_left0(i, 0)) * v[0] +
                                       T(view.R_left1_left0(i, 1)) * v[1] +
                                       T(view.R_left1_left0(i, 2)) * v[2];
    }
    return Vector{r[0] - (x[kTurnY] * r[2] - x[kTurnZ] * r[1]),
                  r[1] - (x[kTurnZ] * r[0] - x[kTurnX] * r[2]),
                  r[2] - (x[kTurnX] * r[1] - x[kTurnY] * r[0])};
  };
  const Vector ray =
      turned({(x[kLeft0U] - T(c.cx)) / T(c.fx), (x[kLeft0V] - T(c.cy)) / T(c.fy), T(1.0)});
  const Vector d = turned({x[kDirectionX], x[kDirectionY], x[kDirectionZ]});
  const T per_px = T(1.0 / (c.fx * c.baseline_m));
  const T inverse_depth = x[kDisparity] * per_px;
  const T moved = x[kScale] * inverse_depth;
  const Vector Y{ray[0] - moved * d[0], ray[1] - moved * d[1], ray[2] - moved * d[2]};

  ScalePoint<T> point;
  point.in_front = Y[2] > T(0.05);  // of the depth before: nearer, no row is to be trusted
  if (!point.in_front) return point;
  const T px = Y[0] / Y[2];
  const T py = Y[1] / Y[2];
  point.e = {T(c.fx) * px + T(c.cx) - x[kLeft1U], T(c.fy) * py + T(c.cy) - x[kLeft1V]};
  // Along -d, which both the scale and the disparity move the point.
  const std::array<T, 2> along{T(c.fx) * (px * d[2] - d[0]) / Y[2],
                               T(c.fy) * (py * d[2] - d[1]) / Y[2]};
  point.slope = {along[0] * inverse_depth, along[1] * inverse_depth};
  const T by_disparity = x[kScale] * per_px;
  const std::array<T, 2> g{along[0] * by_disparity, along[1] * by_disparity};
  point.weighted_slope = apply_scale_information(x, g, point.slope);
  const std::array<T, 2> weighted = apply_scale_information(x, g, point.e);
  point.square = point.e[0] * weighted[0] + point.e[1] * weighted[1];
  return point;
}

/// Derivative of Huber's kernel with respect to the square.
template <typename T>
T huber_slope(const T& square, double kernel_square) {
  using std::sqrt;
  if (square <= T(kernel_square)) return T(1.0);
  return T(sqrt(T(T(kernel_square) / square)));
}

/// The point's share of F(s).
template <typename T>
T scale_score(const ScaleView& view, const ScaleInputs<T>& x) {
  const ScalePoint<T> p = evaluate_scale_point(view, x);
  if (!p.in_front) return T(0.0);
  return x[kWeight] * huber_slope(p.square, view.kernel_square) *
         (p.weighted_slope[0] * p.e[0] + p.weighted_slope[1] * p.e[1]);
}

}  // namespace imslam::vo::detail

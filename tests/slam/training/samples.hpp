#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "slam/training/triplet_generator.hpp"

namespace imslam::training {

/// Few procedural textures: the same on every machine, and soon made.
inline TripletOptions quick_options() {
  TripletOptions options;
  options.textures = "procedural";
  options.texture_count = 12;
  return options;
}

/// Made once per process.
inline const TripletGenerator& quick_generator() {
  static const TripletGenerator generator(quick_options());
  return generator;
}

/// Catmull-Rom weights of the samples at -1, 0, 1, 2 for a place in [0, 1].
inline std::array<double, 4> cubic_weights(double x) {
  return {0.5 * x * (-1.0 + x * (2.0 - x)), 0.5 * (2.0 + x * x * (-5.0 + 3.0 * x)),
          0.5 * x * (1.0 + x * (4.0 - 3.0 * x)), 0.5 * x * x * (x - 1.0)};
}

/// An image between its pixels, bicubic; borders are repeated.
inline double look(const Triplet& triplet, const std::vector<float>& image, double u, double v) {
  const int column = static_cast<int>(std::floor(u));
  const int row = static_cast<int>(std::floor(v));
  const std::array<double, 4> across = cubic_weights(u - column);
  const std::array<double, 4> down = cubic_weights(v - row);
  double sum = 0.0;
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      const int r = std::clamp(row + y - 1, 0, triplet.camera.height - 1);
      const int c = std::clamp(column + x - 1, 0, triplet.camera.width - 1);
      sum += down[static_cast<std::size_t>(y)] * across[static_cast<std::size_t>(x)] *
             double{image[triplet.index(r, c)]};
    }
  }
  return sum;
}

/// Differences between left0 and right0 where the match is visible; `row_error` moves the match.
inline std::vector<double> stereo_residuals(const Triplet& triplet, double row_error = 0.0) {
  std::vector<double> residuals;
  for (int row = 2; row + 2 < triplet.camera.height; ++row) {
    for (int column = 0; column < triplet.camera.width; ++column) {
      const std::size_t at = triplet.index(row, column);
      if (triplet.disparity_state[at] != MatchState::kVisible) continue;
      const double seen =
          look(triplet, triplet.right0, column - double{triplet.disparity[at]}, row + row_error);
      residuals.push_back(std::abs(seen - double{triplet.left0[at]}));
    }
  }
  return residuals;
}

/// The same of left0 and left1; `error` moves the match diagonally.
inline std::vector<double> flow_residuals(const Triplet& triplet, double error = 0.0) {
  std::vector<double> residuals;
  for (int row = 0; row < triplet.camera.height; ++row) {
    for (int column = 0; column < triplet.camera.width; ++column) {
      const std::size_t at = triplet.index(row, column);
      if (triplet.flow_state[at] != MatchState::kVisible) continue;
      const double u = std::max(0.0, column + double{triplet.flow_u[at]} - error);
      const double v = std::max(0.0, row + double{triplet.flow_v[at]} - error);
      residuals.push_back(std::abs(look(triplet, triplet.left1, u, v) - double{triplet.left0[at]}));
    }
  }
  return residuals;
}

inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// All numbers of a triplet are the same.
inline bool same(const Triplet& a, const Triplet& b) {
  return a.left0 == b.left0 && a.right0 == b.right0 && a.left1 == b.left1 &&
         a.disparity == b.disparity && a.flow_u == b.flow_u && a.flow_v == b.flow_v &&
         a.disparity_state == b.disparity_state && a.flow_state == b.flow_state &&
         a.camera.fx == b.camera.fx && a.camera.baseline_m == b.camera.baseline_m &&
         (a.T_left1_left0.inverse() * b.T_left1_left0).log().norm() == 0.0;
}

}  // namespace imslam::training

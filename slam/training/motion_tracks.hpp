#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "slam/base/random.hpp"

namespace imslam::training {

inline constexpr double kKnot_s = 0.05;  ///< [s] between two control poses of a motion spline

/// A quantity at the control times of a motion spline, kKnot_s apart. What moves is first planned
/// as set-points (steps), then smoothed: like a vehicle whose controller follows commands.
template <typename Value>
using Track = std::vector<Value>;
using ScalarTrack = Track<double>;
using VectorTrack = Track<Eigen::Vector3d>;

/// Knots of the half width of one of the three boxes that smooth over `width_s` altogether.
inline std::size_t box_half_width(double width_s) {
  return static_cast<std::size_t>(std::max(0.0, std::floor(width_s / (6.0 * kKnot_s) + 1e-9)));
}

/// Moving average of 2 half_width + 1 values; ends are continued as constants.
template <typename Value>
Track<Value> box_average(const Track<Value>& track, std::size_t half_width) {
  const auto last = static_cast<std::ptrdiff_t>(track.size()) - 1;
  const auto reach = static_cast<std::ptrdiff_t>(half_width);
  const auto at = [&](std::ptrdiff_t i) -> const Value& {
    return track[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, last))];
  };
  Track<Value> result(track.size(), track.front());
  Value sum = track.front();
  for (std::ptrdiff_t k = 1; k <= reach; ++k) sum += at(-k) + at(k);
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    result[static_cast<std::size_t>(i)] = sum * (1.0 / static_cast<double>(2 * reach + 1));
    sum += at(i + reach + 1) - at(i - reach);
  }
  return result;
}

/// Smooth over `width_s` altogether, centred: a step becomes a ramp with two continuous
/// derivatives (after the spline's own four) that begins width_s / 2 early and ends as much late;
/// what is constant for longer stays constant. Steepest slope: 2.25 / width_s times the step.
template <typename Value>
Track<Value> smoothed(Track<Value> track, double width_s) {
  const std::size_t half_width = box_half_width(width_s);
  if (half_width == 0 || track.empty()) return track;
  for (int pass = 0; pass < 3; ++pass) track = box_average(track, half_width);
  return track;
}

/// Integral over time of a track of rates, `start` at the first knot.
template <typename Value>
Track<Value> integrated(const Track<Value>& rate, Value start) {
  Track<Value> result;
  result.reserve(rate.size());
  for (std::size_t k = 0; k < rate.size(); ++k) {
    result.push_back(start);
    if (k + 1 < rate.size()) start += 0.5 * kKnot_s * (rate[k] + rate[k + 1]);
  }
  return result;
}

/// Smooth noise: normal, standard deviation `sigma`, forgets itself within `width_s`; up to about
/// 0.8 / width_s hertz.
ScalarTrack smooth_noise(Random& random, std::size_t count, double sigma, double width_s);
VectorTrack smooth_noise3(Random& random, std::size_t count, double sigma, double width_s);

/// low (high / low)^u, u uniform: every order of magnitude is as likely.
double log_uniform(Random& random, double low, double high);

}  // namespace imslam::training

#include "datasets/simulation/paths.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector2d;

template <typename Value>
std::vector<Value> box_filtered(const std::vector<Value>& values, int half_width) {
  const auto count = static_cast<int>(values.size());
  const auto at = [&](int i) {
    return values[static_cast<std::size_t>(((i % count) + count) % count)];
  };
  std::vector<Value> result(values.size());
  Value sum = at(0);
  for (int k = 1; k <= half_width; ++k) sum += at(k) + at(-k);
  for (int i = 0; i < count; ++i) {
    result[static_cast<std::size_t>(i)] = sum / static_cast<double>(2 * half_width + 1);
    sum += at(i + half_width + 1) - at(i - half_width);
  }
  return result;
}

double wrapped_angle(double angle) { return std::remainder(angle, 2.0 * M_PI); }

}  // namespace

Wobble::Wobble(Random& random, double amplitude, double low_hz, double high_hz) : waves_{} {
  double total = 0.0;
  for (Wave& wave : waves_) {
    const double hertz = low_hz * std::pow(high_hz / low_hz, random.uniform());
    wave = {low_hz / hertz + 0.2, 2.0 * M_PI * hertz, random.uniform(0.0, 2.0 * M_PI)};
    total += wave.amplitude;
  }
  for (Wave& wave : waves_) wave.amplitude *= amplitude / total;
}

double Wobble::operator()(double t) const {
  double sum = 0.0;
  for (const Wave& wave : waves_) sum += wave.amplitude * std::sin(wave.rate * t + wave.phase);
  return sum;
}

PlanarLoop::PlanarLoop(const std::vector<Vector2d>& corners, const Limits& limits) {
  expects(corners.size() >= 3, "PlanarLoop: at least 3 corners");
  const double step = std::clamp(limits.smoothing_m / 20.0, 0.02, 0.2);
  const int half_width = std::max(1, static_cast<int>(limits.smoothing_m / (2.0 * step)));
  resample(corners, step);
  for (int pass = 0; pass < 3; ++pass) points_ = box_filtered(points_, half_width);
  measure();
  time_it(limits, half_width);
}

void PlanarLoop::resample(const std::vector<Vector2d>& corners, double step) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d& from = corners[i];
    const Vector2d& to = corners[(i + 1) % corners.size()];
    const int pieces = std::max(1, static_cast<int>(std::lround((to - from).norm() / step)));
    for (int k = 0; k < pieces; ++k) points_.push_back(from + (to - from) * k / pieces);
  }
}

void PlanarLoop::measure() {
  const std::size_t count = points_.size();
  distances_ = {0.0};
  yaws_.clear();
  for (std::size_t i = 0; i <= count; ++i) {
    const Vector2d& before = points_[(i + count - 1) % count];
    const Vector2d& here = points_[i % count];
    const Vector2d& after = points_[(i + 1) % count];
    const double yaw = std::atan2(after.y() - before.y(), after.x() - before.x());
    yaws_.push_back(yaws_.empty() ? yaw : yaws_.back() + wrapped_angle(yaw - yaws_.back()));
    if (i < count) distances_.push_back(distances_.back() + (after - here).norm());
  }
}

void PlanarLoop::time_it(const Limits& limits, int half_width) {
  const std::size_t count = points_.size();
  std::vector<double> speeds(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double bend = std::abs(yaws_[i + 1] - yaws_[i]) / (distances_[i + 1] - distances_[i]);
    const double by_turning = limits.turn_rate / std::max(bend, 1e-6);
    const double by_force = std::sqrt(limits.lateral_accel / std::max(bend, 1e-6));
    speeds[i] = std::min({limits.speed, by_turning, by_force});
  }
  // Brake before the bend, speed up after it: the lowest limit around, then smoothed.
  std::vector<double> cautious = speeds;
  const auto n = static_cast<int>(count);
  const int reach = 4 * half_width;  // of the two smoothing passes below together
  for (int i = 0; i < n; ++i) {
    for (int k = -reach; k <= reach; ++k) {
      const auto j = static_cast<std::size_t>(((i + k) % n + n) % n);
      cautious[static_cast<std::size_t>(i)] =
          std::min(cautious[static_cast<std::size_t>(i)], speeds[j]);
    }
  }
  for (int pass = 0; pass < 2; ++pass) cautious = box_filtered(cautious, 2 * half_width);
  times_ = {0.0};
  for (std::size_t i = 0; i < count; ++i) {
    times_.push_back(times_.back() + (distances_[i + 1] - distances_[i]) / cautious[i]);
  }
}

PlanarLoop::Pose PlanarLoop::at_index(double index) const {
  const std::size_t count = points_.size();
  const auto i = std::min(static_cast<std::size_t>(index), count - 1);
  const double share = index - static_cast<double>(i);
  Pose pose;
  pose.position = points_[i] + share * (points_[(i + 1) % count] - points_[i]);
  pose.yaw = yaws_[i] + share * (yaws_[i + 1] - yaws_[i]);
  pose.distance = distances_[i] + share * (distances_[i + 1] - distances_[i]);
  return pose;
}

namespace {

/// Fractional index of `value` in an increasing table.
double index_in(const std::vector<double>& table, double value) {
  const auto above = std::upper_bound(table.begin() + 1, table.end() - 1, value);
  const auto i = static_cast<std::size_t>(above - table.begin() - 1);
  return static_cast<double>(i) + (value - table[i]) / (table[i + 1] - table[i]);
}

}  // namespace

PlanarLoop::Pose PlanarLoop::at_time(double t) const {
  const double laps = std::floor(t / times_.back());
  Pose pose = at_index(index_in(times_, t - laps * times_.back()));
  pose.yaw += laps * (yaws_.back() - yaws_.front());
  pose.distance += laps * length();
  return pose;
}

PlanarLoop::Pose PlanarLoop::at_distance(double s) const {
  const double laps = std::floor(s / length());
  Pose pose = at_index(index_in(distances_, s - laps * length()));
  pose.yaw += laps * (yaws_.back() - yaws_.front());
  pose.distance = s;
  return pose;
}

double PlanarLoop::clearance(const Vector2d& place) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vector2d& point : points_) nearest = std::min(nearest, (point - place).squaredNorm());
  return std::sqrt(nearest);
}

void add_arc(
    std::vector<Vector2d>& points, const Vector2d& centre, double radius, double from, double to) {
  const int pieces = std::max(2, static_cast<int>(std::abs(to - from) / 0.1));
  for (int k = 0; k <= pieces; ++k) {
    const double angle = from + (to - from) * k / pieces;
    points.push_back(centre + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
}

}  // namespace imslam::simulation

#include "datasets/simulation/motion_spline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

constexpr int kOrder = 6;
using Weights = std::array<double, kOrder>;

struct Basis {
  Weights value;
  Weights first;   ///< d/du
  Weights second;  ///< d^2/du^2
};

// Column j: coefficients of 1, u, ..., u^5 of 120 b_j(u), the uniform quintic B-spline.
constexpr double kBlend[kOrder][kOrder] = {{1, -5, 10, -10, 5, -1},  {26, -50, 20, 20, -20, 5},
                                           {66, 0, -60, 0, 30, -10}, {26, 50, 20, -20, -20, 10},
                                           {1, 5, 10, 10, 5, -5},    {0, 0, 0, 0, 0, 1}};

Basis basis(double u) {
  Basis result{};
  for (std::size_t j = 0; j < kOrder; ++j) {
    double value = 0.0;
    double first = 0.0;
    double second = 0.0;
    for (int power = kOrder - 1; power >= 0; --power) {  // Horner with derivatives
      second = second * u + 2.0 * first;
      first = first * u + value;
      value = value * u + kBlend[j][power];
    }
    result.value[j] = value / 120.0;
    result.first[j] = first / 120.0;
    result.second[j] = second / 120.0;
  }
  return result;
}

/// From b_j to B_j = b_j + b_{j+1} + ...
void accumulate(Weights& weights) {
  for (std::size_t j = kOrder - 1; j > 0; --j) weights[j - 1] += weights[j];
}

}  // namespace

MotionSpline::MotionSpline(double knot_dt_s, std::vector<lie::SE3d> control_poses)
    : knot_dt_s_(knot_dt_s), control_poses_(std::move(control_poses)) {
  expects(knot_dt_s > 0.0, "MotionSpline: knot_dt_s must be positive");
  expects(control_poses_.size() >= kOrder, "MotionSpline: at least 6 control poses");
  duration_s_ = knot_dt_s * static_cast<double>(control_poses_.size() - kOrder + 1);
  for (std::size_t k = 0; k + 1 < control_poses_.size(); ++k) {
    steps_.push_back(
        (control_poses_[k].rotation().inverse() * control_poses_[k + 1].rotation()).log());
  }
}

std::size_t MotionSpline::control_count(double knot_dt_s, double duration_s) {
  return static_cast<std::size_t>(std::ceil(duration_s / knot_dt_s - 1e-9)) + kOrder;
}

MotionState MotionSpline::at(double time_s) const {
  const double knots = std::clamp(time_s, 0.0, duration_s_) / knot_dt_s_;
  const std::size_t i = std::min(static_cast<std::size_t>(knots), control_poses_.size() - kOrder);
  Basis b = basis(knots - static_cast<double>(i));
  const double rate = 1.0 / knot_dt_s_;

  MotionState state;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (std::size_t j = 0; j < kOrder; ++j) {
    const Eigen::Vector3d& control = control_poses_[i + j].translation();
    position += b.value[j] * control;
    state.v_world += rate * b.first[j] * control;
    state.a_world += rate * rate * b.second[j] * control;
  }

  for (Weights* weights : {&b.value, &b.first, &b.second}) accumulate(*weights);
  lie::SO3d R = control_poses_[i].rotation();
  for (std::size_t j = 1; j < kOrder; ++j) {
    const Eigen::Vector3d& d = steps_[i + j - 1];
    const lie::SO3d A = lie::SO3d::exp(b.value[j] * d);
    const Eigen::Vector3d d_rate = rate * b.first[j] * d;
    R = R * A;
    state.omega_body = A.inverse() * state.omega_body + d_rate;
    state.alpha_body = A.inverse() * state.alpha_body + state.omega_body.cross(d_rate) +
                       rate * rate * b.second[j] * d;
  }
  state.T_world_body = lie::SE3d(R, position);
  return state;
}

}  // namespace imslam::simulation

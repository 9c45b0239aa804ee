#pragma once

#include <array>
#include <cmath>

#include "pgo/pose_velocity_graph.hpp"
#include "slam/base/random.hpp"
#include "slam/base/time.hpp"

namespace imslam::testing {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

template <int kRows, int kColumns>
Eigen::Matrix<double, kRows, kColumns> random_matrix(Random& random) {
  Eigen::Matrix<double, kRows, kColumns> M;
  for (Eigen::Index i = 0; i < M.size(); ++i) M.data()[i] = random.normal();
  return M;
}

/// A well-conditioned covariance with correlations, of the given standard deviation.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> random_covariance(Random& random, double sigma) {
  const Eigen::Matrix<double, kSize, kSize> A = random_matrix<kSize, kSize>(random);
  return sigma * sigma *
         (Eigen::Matrix<double, kSize, kSize>::Identity() + 0.1 * A * A.transpose());
}

inline lie::SE3d random_pose(Random& random, double size = 1.0, double angle = 1.0) {
  return {lie::SO3d::exp(angle * random.normal3()), size * random.normal3()};
}

/// True states along a wavy path, world z up; dt [s] apart.
inline std::vector<pgo::State> wavy_states(int count,
                                           double dt_s = 0.05,
                                           const ImuBias& bias = {}) {
  std::vector<pgo::State> states;
  for (int i = 0; i < count; ++i) {
    const double t = i * dt_s;
    pgo::State state;
    state.time_ns = 1'000'000'000 + to_nanoseconds(t);
    const Eigen::Vector3d p(2.0 * std::sin(0.7 * t), 1.5 * std::cos(0.9 * t) - 1.5,
                            0.4 * std::sin(1.3 * t));
    const Eigen::Vector3d v(1.4 * std::cos(0.7 * t), -1.35 * std::sin(0.9 * t),
                            0.52 * std::cos(1.3 * t));
    const Eigen::Vector3d theta(0.2 * std::sin(0.8 * t), 0.3 * std::sin(1.1 * t), 0.5 * t);
    state.nav = {lie::SE3d(lie::SO3d::exp(theta), p), v};
    state.bias = bias;
    states.push_back(state);
  }
  return states;
}

inline RelativeMotion exact_visual_motion(const pgo::State& a, const pgo::State& b) {
  RelativeMotion motion;
  motion.time0_ns = a.time_ns;
  motion.time1_ns = b.time_ns;
  motion.T_body0_body1 = a.nav.T_world_body.inverse() * b.nav.T_world_body;
  motion.covariance.diagonal() << Eigen::Vector3d::Constant(1e-6), Eigen::Vector3d::Constant(1e-7);
  motion.valid = true;
  return motion;
}

/// The preintegrated motion that fits two states exactly at the bias of the first. The bias
/// Jacobians are those of a body at rest, good enough to make the biases observable.
inline ImuMotion exact_imu_motion(const pgo::State& a,
                                  const pgo::State& b,
                                  const Eigen::Vector3d& gravity = {0, 0, -9.81}) {
  ImuMotion motion;
  motion.time0_ns = a.time_ns;
  motion.time1_ns = b.time_ns;
  const double dt = to_seconds(b.time_ns - a.time_ns);
  motion.dt_s = dt;
  const lie::SO3d R_inverse = a.nav.T_world_body.rotation().inverse();
  motion.dR = R_inverse * b.nav.T_world_body.rotation();
  motion.dv = R_inverse * (b.nav.v_world - a.nav.v_world - gravity * dt);
  motion.dp = R_inverse * (b.nav.T_world_body.translation() - a.nav.T_world_body.translation() -
                           a.nav.v_world * dt - 0.5 * dt * dt * gravity);
  motion.bias = a.bias;
  motion.J_dR_bias.leftCols<3>() = -dt * Eigen::Matrix3d::Identity();
  motion.J_dv_bias.rightCols<3>() = -dt * Eigen::Matrix3d::Identity();
  motion.J_dp_bias.rightCols<3>() = -0.5 * dt * dt * Eigen::Matrix3d::Identity();
  motion.covariance.diagonal() << Eigen::Vector3d::Constant(1e-8), Eigen::Vector3d::Constant(1e-6),
      Eigen::Vector3d::Constant(1e-9);
  motion.valid = true;
  return motion;
}

inline pgo::State disturbed(const pgo::State& state, Random& random, double size) {
  pgo::State result = state;
  result.nav = state.nav.plus(size * random_matrix<9, 1>(random));
  return result;
}

/// A graph of the true states with exact edges, anchored, started `disturbance` away.
inline pgo::PoseVelocityGraph chain_graph(const std::vector<pgo::State>& truth,
                                          const pgo::GraphOptions& options,
                                          bool with_imu,
                                          double disturbance,
                                          std::uint64_t seed = 1) {
  Random random(seed);
  pgo::PoseVelocityGraph graph(options);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    graph.add_state(i == 0 ? truth[i] : disturbed(truth[i], random, disturbance));
    if (i == 0) continue;
    const int to = static_cast<int>(i);
    graph.add_visual_edge(to - 1, to, exact_visual_motion(truth[i - 1], truth[i]));
    if (with_imu) graph.add_imu_edge(to - 1, to, exact_imu_motion(truth[i - 1], truth[i]));
  }
  if (with_imu) {
    graph.anchor_position_and_heading(0, truth[0].nav.T_world_body);
    graph.add_bias_prior(0, truth[0].bias, 0.1, 0.3);
  } else {
    graph.anchor_pose(0, truth[0].nav.T_world_body);
  }
  return graph;
}

inline double largest_position_error(const std::vector<pgo::State>& actual,
                                     const std::vector<pgo::State>& expected) {
  double error = 0.0;
  for (std::size_t i = 0; i < actual.size(); ++i) {
    error = std::max(error, (actual[i].nav.T_world_body.translation() -
                             expected[i].nav.T_world_body.translation())
                                .norm());
  }
  return error;
}

}  // namespace imslam::testing

#pragma once

#include <Eigen/Cholesky>

#include "slam/base/error.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam::system::testing {

using imslam::testing::random_covariance;
using imslam::testing::random_matrix;

inline constexpr std::size_t kOutlier = 5;  ///< visual edge far out on the robust kernel

template <int kSize>
Eigen::Matrix<double, kSize, 1> drawn_from(const Eigen::Matrix<double, kSize, kSize>& covariance,
                                           Random& random) {
  return covariance.llt().matrixL() * random_matrix<kSize, 1>(random);
}

/// A graph whose measurements contradict each other by their sigmas of `noise` [m, rad, m/s], with
/// edges over three states and one outlier; with an IMU every global unknown is estimated too.
inline pgo::PoseVelocityGraph contradictory_graph(int states, bool inertial, double noise = 0.02) {
  Random random(77);
  const auto truth = imslam::testing::wavy_states(states, 0.5);
  pgo::GraphOptions options;
  options.gyro_random_walk = 0.01;
  options.accel_random_walk = 0.01;
  options.estimate_gravity = options.estimate_time_offset = inertial;
  options.estimate_focal_error = options.estimate_camera_rotation = inertial;
  options.estimate_disparity_offset = true;
  pgo::PoseVelocityGraph graph(options);
  for (const pgo::State& state : truth) graph.add_state(state);
  const auto at = [&truth](int i) -> const pgo::State& {
    return truth[static_cast<std::size_t>(i)];
  };
  const auto add_visual = [&](int i, int j) {
    const double error = graph.visual_edges().size() == kOutlier ? 10.0 : 1.0;
    RelativeMotion motion = imslam::testing::exact_visual_motion(at(i), at(j));
    motion.covariance = random_covariance<6>(random, noise);
    motion.J_disparity_offset = 0.01 * random_matrix<6, 1>(random);
    motion.J_focal_error = 0.1 * random_matrix<6, 1>(random);
    motion.T_body0_body1 =
        motion.T_body0_body1 * lie::SE3d::exp(error * drawn_from<6>(motion.covariance, random));
    expects(graph.add_visual_edge(i, j, motion), "a visual motion of use");
  };
  const auto add_inertial = [&](int i, int j) {
    ImuMotion motion = imslam::testing::exact_imu_motion(at(i), at(j));
    motion.covariance = random_covariance<9>(random, noise);
    motion.J_time_offset = 0.1 * random_matrix<9, 1>(random);
    const Eigen::Matrix<double, 9, 1> error = drawn_from<9>(motion.covariance, random);
    motion.dR = motion.dR * lie::SO3d::exp(error.head<3>());
    motion.dv += error.segment<3>(3);
    motion.dp += error.tail<3>();
    expects(graph.add_imu_edge(i, j, motion), "an inertial motion of use");
  };
  for (int j = 1; j < states; ++j) {
    add_visual(j - 1, j);
    if (j >= 3) add_visual(j - 3, j);
    if (inertial) add_inertial(j - 1, j);
  }
  graph.anchor_pose(0, truth[0].nav.T_world_body);
  graph.add_disparity_offset_prior(0.0, 0.5);
  if (!inertial) return graph;
  graph.add_bias_prior(0, {}, 0.05, 0.1);
  graph.add_bias_prior(states / 2, {0.01 * random.normal3(), 0.01 * random.normal3()}, 0.02, 0.05);
  graph.add_gravity_prior(-Eigen::Vector3d::UnitZ(), 0.1);
  graph.add_focal_error_prior(0.0, 0.05);
  graph.add_time_offset_prior(0.0, 0.05);
  graph.set_camera({lie::SO3d::exp({0.3, -0.2, 1.2}), {0.05, 0.02, -0.01}});
  graph.add_camera_rotation_prior({0.005, 0.0, -0.01}, 0.01);
  return graph;
}

}  // namespace imslam::system::testing

// The standard deviations of what is estimated once for a graph, against the spread of many runs.
#include <gtest/gtest.h>

#include <cmath>

#include "pgo/pose_velocity_graph.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam::pgo {
namespace {

using testing::exact_imu_motion;
using testing::exact_visual_motion;
using testing::Vector6;
using testing::Vector9;

/// How sure one is of the globals before looking.
constexpr double kOffsetPrior_px = 1.0;
constexpr double kFocalPrior = 0.02;
constexpr double kTimePrior_s = 0.02;
constexpr double kTurnPrior_rad = 0.01;
constexpr double kShapePrior = 0.02;

const lie::SE3d kT_body_left(lie::SO3d::exp({0.3, -0.2, 1.2}), Eigen::Vector3d(0.05, 0.02, -0.01));

GraphOptions everything_estimated() {
  GraphOptions options;
  options.kernel = "none";
  options.estimate_disparity_offset = true;
  options.estimate_focal_error = true;
  options.estimate_time_offset = true;
  options.estimate_camera_rotation = true;
  options.estimate_gyro_shape = true;
  return options;
}

/// What vision measures with a wrong focal length (turns too large, steps too) and disparities that
/// are all off (steps too short), and noise.
RelativeMotion noisy_visual_motion(const State& a,
                                   const State& b,
                                   const Globals& truth,
                                   Random& random) {
  RelativeMotion motion = exact_visual_motion(a, b);
  const Vector6 screw = motion.T_body0_body1.log();
  motion.J_focal_error << Eigen::Vector3d::Zero(), -screw.tail<3>();
  motion.J_disparity_offset << 0.04 * screw.head<3>(), Eigen::Vector3d::Zero();
  Vector6 error;
  error << random.normal3(), random.normal3();
  error = error.cwiseProduct(motion.covariance.diagonal().cwiseSqrt());
  const Vector6 shift =
      motion.J_focal_error * truth.focal_error + motion.J_disparity_offset * truth.disparity_offset;
  const lie::SE3d turn = kT_body_left *
                         lie::SE3d(lie::SO3d::exp(truth.camera_rotation), Eigen::Vector3d::Zero()) *
                         kT_body_left.inverse();
  motion.T_body0_body1 =
      turn.inverse() * motion.T_body0_body1 * lie::SE3d::exp(error) * lie::SE3d::exp(-shift) * turn;
  return motion;
}

/// What an IMU measures whose clock and gyro are off, and noise. Rates change along the path.
ImuMotion noisy_imu_motion(
    const State& a, const State& b, double phase, const Globals& truth, Random& random) {
  ImuMotion motion = exact_imu_motion(a, b);
  motion.J_time_offset << Eigen::Vector3d::Constant(0.02 * std::sin(phase)),
      Eigen::Vector3d::Constant(0.1 * std::cos(phase)), Eigen::Vector3d::Zero();
  Vector9 error;
  error << random.normal3(), random.normal3(), random.normal3();
  error = error.cwiseProduct(motion.covariance.diagonal().cwiseSqrt()) -
          motion.J_time_offset * truth.time_offset_s;
  const Eigen::Vector3d turn = motion.dR.log();
  motion.dR = lie::SO3d::exp(turn + truth.gyro_shape * turn);
  motion.dR = motion.dR * lie::SO3d::exp(error.head<3>());
  motion.dv += error.segment<3>(3);
  motion.dp += error.tail<3>();
  return motion;
}

Globals draw_globals(Random& random) {
  Globals globals;
  globals.disparity_offset = kOffsetPrior_px * random.normal();
  globals.focal_error = kFocalPrior * random.normal();
  globals.time_offset_s = kTimePrior_s * random.normal();
  globals.camera_rotation = kTurnPrior_rad * random.normal3();
  for (double& entry : globals.gyro_shape.reshaped()) entry = kShapePrior * random.normal();
  return globals;
}

PoseVelocityGraph noisy_graph(const std::vector<State>& states,
                              const Globals& truth,
                              Random& random) {
  PoseVelocityGraph graph(everything_estimated());
  for (const State& state : states) graph.add_state(state);
  for (std::size_t i = 1; i < states.size(); ++i) {
    const auto to = static_cast<int>(i);
    graph.add_visual_edge(to - 1, to, noisy_visual_motion(states[i - 1], states[i], truth, random));
    graph.add_imu_edge(
        to - 1, to,
        noisy_imu_motion(states[i - 1], states[i], 0.8 * static_cast<double>(i), truth, random));
  }
  graph.anchor_position_and_heading(0, states[0].nav.T_world_body);
  graph.add_bias_prior(0, states[0].bias, 1e-4, 1e-3);
  graph.add_disparity_offset_prior(0.0, kOffsetPrior_px);
  graph.add_focal_error_prior(0.0, kFocalPrior);
  graph.add_time_offset_prior(0.0, kTimePrior_s);
  graph.set_camera(kT_body_left);
  graph.add_camera_rotation_prior(Eigen::Vector3d::Zero(), kTurnPrior_rad);
  graph.add_gyro_shape_prior(Eigen::Matrix3d::Zero(), kShapePrior);
  return graph;
}

TEST(GlobalSigmas, AreThoseOfTheErrorsOfManyRuns) {
  constexpr int kRuns = 150;
  const auto states = testing::wavy_states(30);
  Random random(5);
  Vector6 squares = Vector6::Zero();  // of errors in standard deviations
  Eigen::Matrix3d shape_squares = Eigen::Matrix3d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    const Globals truth = draw_globals(random);
    PoseVelocityGraph graph = noisy_graph(states, truth, random);
    ASSERT_TRUE(graph.solve().converged);
    const auto uncertainty = graph.uncertainty();
    ASSERT_TRUE(uncertainty);
    const GlobalSigmas& sigmas = uncertainty->globals;
    EXPECT_LT(*sigmas.disparity_offset, 0.9 * kOffsetPrior_px);  // the graph has learned something
    EXPECT_LT(*sigmas.focal_error, 0.9 * kFocalPrior);
    EXPECT_LT(*sigmas.time_offset_s, 0.9 * kTimePrior_s);
    EXPECT_LT(sigmas.camera_rotation->maxCoeff(), 0.9 * kTurnPrior_rad);
    const Globals& found = graph.globals();
    Vector6 errors;
    errors.head<3>() << (found.disparity_offset - truth.disparity_offset) /
                            *sigmas.disparity_offset,
        (found.focal_error - truth.focal_error) / *sigmas.focal_error,
        (found.time_offset_s - truth.time_offset_s) / *sigmas.time_offset_s;
    errors.tail<3>() =
        (found.camera_rotation - truth.camera_rotation).cwiseQuotient(*sigmas.camera_rotation);
    squares += errors.cwiseAbs2() / kRuns;
    EXPECT_LT(sigmas.gyro_shape->mean(), 0.9 * kShapePrior);
    shape_squares +=
        (found.gyro_shape - truth.gyro_shape).cwiseQuotient(*sigmas.gyro_shape).cwiseAbs2() / kRuns;
  }
  for (const double square : squares) {  // chance alone moves the root by 6 %
    EXPECT_GT(std::sqrt(square), 1.0 / 1.25) << squares.transpose();
    EXPECT_LT(std::sqrt(square), 1.25) << squares.transpose();
  }
  for (const double square : shape_squares.reshaped()) {
    EXPECT_GT(std::sqrt(square), 1.0 / 1.25) << shape_squares;
    EXPECT_LT(std::sqrt(square), 1.25) << shape_squares;
  }
}

TEST(GlobalSigmas, AreEmptyForWhatIsHeld) {
  GraphOptions options = everything_estimated();
  options.estimate_focal_error = false;
  options.estimate_time_offset = false;
  options.estimate_camera_rotation = false;
  options.estimate_gyro_shape = false;
  auto graph = testing::chain_graph(testing::wavy_states(4), options, true, 0.0);
  graph.add_disparity_offset_prior(0.0, 0.5);
  const auto uncertainty = graph.uncertainty();
  ASSERT_TRUE(uncertainty);
  EXPECT_NEAR(*uncertainty->globals.disparity_offset, 0.5, 1e-9);  // no edge depends on it
  EXPECT_FALSE(uncertainty->globals.focal_error);
  EXPECT_FALSE(uncertainty->globals.time_offset_s);
  EXPECT_FALSE(uncertainty->globals.camera_rotation);
  EXPECT_FALSE(uncertainty->globals.gyro_shape);
}

}  // namespace
}  // namespace imslam::pgo

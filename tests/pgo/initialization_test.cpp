#include "pgo/initialization.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam::pgo {
namespace {

using Eigen::Vector3d;
using testing::wavy_states;

struct Data {
  std::vector<State> truth;
  std::vector<RelativeMotion> visual;
  std::vector<ImuMotion> inertial;
};

Data measure(std::vector<State> truth, const ImuBias& bias_in_motions = {}) {
  Data data{std::move(truth), {}, {}};
  for (std::size_t i = 0; i + 1 < data.truth.size(); ++i) {
    data.visual.push_back(testing::exact_visual_motion(data.truth[i], data.truth[i + 1]));
    ImuMotion motion = testing::exact_imu_motion(data.truth[i], data.truth[i + 1]);
    // Integrated with `bias_in_motions` instead of the true bias, exactly to first order.
    Eigen::Matrix<double, 6, 1> db;
    db << bias_in_motions.gyro - motion.bias.gyro, bias_in_motions.accel - motion.bias.accel;
    motion.dR = motion.dR * lie::SO3d::exp(motion.J_dR_bias * db);
    motion.dv += motion.J_dv_bias * db;
    motion.dp += motion.J_dp_bias * db;
    motion.bias = bias_in_motions;
    data.inertial.push_back(motion);
  }
  return data;
}

/// Truth, seen from the world that initialisation is free to choose.
void expect_states_match(const Initialization& result, const Data& data, double tolerance) {
  ASSERT_TRUE(result.success) << result.reason;
  ASSERT_EQ(result.states.size(), data.truth.size());
  const lie::SE3d T_new_old =
      result.states[0].nav.T_world_body * data.truth[0].nav.T_world_body.inverse();
  EXPECT_LT((T_new_old.rotation() * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), tolerance);
  for (std::size_t i = 0; i < data.truth.size(); ++i) {
    lie::NavState expected;
    expected.T_world_body = T_new_old * data.truth[i].nav.T_world_body;
    expected.v_world = T_new_old.rotation() * data.truth[i].nav.v_world;
    EXPECT_LT(result.states[i].nav.minus(expected).cwiseAbs().maxCoeff(), 10.0 * tolerance) << i;
    EXPECT_EQ(result.states[i].time_ns, data.truth[i].time_ns);
  }
}

TEST(Initialization, FindsGravityVelocitiesAndGyroBiasInMotion) {
  ImuBias bias;
  bias.gyro << -0.003, 0.021, 0.079;
  const Data data = measure(wavy_states(100, 0.1, bias));
  const Initialization result = initialize(data.visual, data.inertial);
  expect_states_match(result, data, 1e-5);
  EXPECT_LT((result.bias.gyro - bias.gyro).norm(), 1e-7);
}

TEST(Initialization, WorldIsLevelWithHeadingZeroAndPositionZero) {
  const Data data = measure(wavy_states(40, 0.1));
  const Initialization result = initialize(data.visual, data.inertial);
  ASSERT_TRUE(result.success) << result.reason;
  const lie::SE3d& first = result.states[0].nav.T_world_body;
  EXPECT_EQ(first.translation().norm(), 0.0);
  const Vector3d x = first.rotation() * Vector3d::UnitX();
  EXPECT_NEAR(x.y(), 0.0, 1e-12);
  EXPECT_GT(x.x(), 0.0);
}

TEST(Initialization, WorksFromRest) {
  std::vector<State> still(30);
  for (std::size_t i = 0; i < still.size(); ++i) {
    still[i].time_ns = static_cast<std::int64_t>(i) * 50'000'000;
    still[i].nav.T_world_body =
        lie::SE3d(lie::SO3d::exp(Vector3d(0.3, -0.4, 1.0)), Vector3d::Zero());
  }
  const Data data = measure(still);
  expect_states_match(initialize(data.visual, data.inertial), data, 1e-6);
}

TEST(Initialization, TellsAnAccelerometerBiasAfterEnoughRotation) {
  ImuBias bias;
  bias.accel << 0.1, -0.05, 0.08;
  const Data data = measure(wavy_states(300, 0.1, bias));
  const Initialization result = initialize(data.visual, data.inertial);
  ASSERT_TRUE(result.success) << result.reason;
  EXPECT_LT((result.bias.accel - bias.accel).norm(), 0.01);
}

TEST(Initialization, ToleratesWrongVisualMotionsAndGaps) {
  ImuBias bias;
  bias.gyro << 0.01, 0.02, -0.01;
  Data data = measure(wavy_states(100, 0.1, bias));
  for (std::size_t i : {10U, 40U, 77U}) {
    data.visual[i].T_body0_body1 =
        data.visual[i].T_body0_body1 * lie::SE3d::exp(0.05 * testing::Vector6::Ones());
  }
  data.visual[20].valid = false;
  data.inertial[60].valid = false;
  const Initialization result = initialize(data.visual, data.inertial);
  ASSERT_TRUE(result.success) << result.reason;
  EXPECT_LT((result.bias.gyro - bias.gyro).norm(), 1e-3);
  const Vector3d down =
      data.truth[0].nav.T_world_body.rotation().inverse() * Vector3d(0.0, 0.0, -9.81);
  EXPECT_LT((result.gravity_body0 - down).norm(), 0.1);
  for (const State& state : result.states) ASSERT_TRUE(state.nav.v_world.allFinite());
}

TEST(Initialization, SaysWhyItFails) {
  Data data = measure(wavy_states(100, 0.1));
  EXPECT_NE(initialize({}, {}).reason.find("only 0 intervals"), std::string::npos);
  for (ImuMotion& motion : data.inertial) {  // g instead of m/s^2
    motion.dv /= 9.81;
    motion.dp /= 9.81;
  }
  const Initialization result = initialize(data.visual, data.inertial);
  EXPECT_FALSE(result.success);
  EXPECT_NE(result.reason.find("measured gravity"), std::string::npos) << result.reason;
  data.inertial.pop_back();
  EXPECT_THROW(initialize(data.visual, data.inertial), ContractError);
}

TEST(Level, UsesTheZAxisForTheHeadingWhereXIsSteep) {
  const lie::SO3d R = level({-9.7, 0.3, 1.5});  // EuRoC's vehicle: x up
  const Vector3d z = R * Vector3d::UnitZ();
  EXPECT_NEAR(z.y(), 0.0, 1e-12);
  EXPECT_GT(z.x(), 0.0);
  EXPECT_LT((R * Vector3d(-9.7, 0.3, 1.5).normalized() + Vector3d::UnitZ()).norm(), 1e-12);
}

}  // namespace
}  // namespace imslam::pgo

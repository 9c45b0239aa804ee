#include "pgo/paper_window.hpp"

#include <gtest/gtest.h>

#include "pgo/paper_factors.hpp"
#include "slam/base/error.hpp"
#include "tests/pgo/check_factor.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam::pgo {
namespace {

using testing::expect_jacobians_match;
using testing::pose_block;
using testing::random_pose;
using testing::vector_block;
using testing::wavy_states;

TEST(PaperFactors, JacobiansMatchNumericDerivatives) {
  for (double angle : {0.0, 1e-9, 1e-4, 0.5, 3.1}) {
    Random random(2);
    const lie::SE3d T0 = random_pose(random);
    const lie::SO3d dR = random_pose(random).rotation();
    const lie::SE3d T1{T0.rotation() * dR * lie::SO3d::exp(angle * random.normal3().normalized()),
                       random.normal3()};
    const testing::Block v0 = vector_block(random.normal3());
    const testing::Block v1 = vector_block(random.normal3());
    expect_jacobians_match(RotationStepFactor(dR, 2.0), {pose_block(T0), pose_block(T1)});
    expect_jacobians_match(VelocityStepFactor(random.normal3(), 0.1), {v0, v1});
    expect_jacobians_match(TranslationVelocityFactor(random.normal3(), 0.3, 0.1),
                           {pose_block(T0), v0, pose_block(T1)});
  }
}

struct Data {
  std::vector<State> truth = wavy_states(30, 0.1);
  std::vector<RelativeMotion> visual;
  std::vector<ImuMotion> inertial;
};

Data measure() {
  Data data;
  for (std::size_t i = 0; i + 1 < data.truth.size(); ++i) {
    data.visual.push_back(testing::exact_visual_motion(data.truth[i], data.truth[i + 1]));
    data.inertial.push_back(testing::exact_imu_motion(data.truth[i], data.truth[i + 1]));
  }
  return data;
}

TEST(PaperWindows, RecoverExactMotionThroughAllWindows) {
  const Data data = measure();
  for (const char* dataset : {"euroc", "kitti"}) {
    PaperOptions options;
    options.dataset = dataset;
    const PaperResult result =
        solve_paper_windows(data.truth[0], data.visual, data.inertial, options);
    ASSERT_EQ(result.states.size(), data.truth.size());
    EXPECT_EQ(result.reports.size(), 4U);  // 29 steps: 8 + 8 + 8 + 5
    for (std::size_t i = 0; i < data.truth.size(); ++i) {
      EXPECT_LT(result.states[i].nav.minus(data.truth[i].nav).norm(), 1e-6) << i;
      EXPECT_EQ(result.states[i].time_ns, data.truth[i].time_ns);
    }
  }
}

TEST(PaperWindows, GiveTheCompromiseOfThePublishedWeights) {
  // One step, a visual turn of +1e-3 rad against the gyro's: r_vo and r_rot share it as w^2.
  const Data data = measure();
  RelativeMotion visual = data.visual[0];
  const Eigen::Vector3d turn(0.0, 0.0, 1e-3);
  visual.T_body0_body1 = lie::SE3d(visual.T_body0_body1.rotation() * lie::SO3d::exp(turn),
                                   visual.T_body0_body1.translation());
  for (const auto& [dataset, share] : {std::pair{"kitti", 1.0 / 101.0}, {"euroc", 16.0 / 20.0}}) {
    PaperOptions options;
    options.dataset = dataset;
    const PaperResult result =
        solve_paper_windows(data.truth[0], {visual}, {data.inertial[0]}, options);
    const Eigen::Vector3d actual = (data.truth[1].nav.T_world_body.rotation().inverse() *
                                    result.states[1].nav.T_world_body.rotation())
                                       .log();
    EXPECT_NEAR(actual.z(), share * 1e-3, 1e-6) << dataset;
  }
}

TEST(PaperWindows, BridgeMissingMotionsWithFiniteStates) {
  Data data = measure();
  data.visual[3].valid = false;
  data.inertial[9].valid = false;
  data.visual[15].valid = data.inertial[15].valid = false;
  const PaperResult result =
      solve_paper_windows(data.truth[0], data.visual, data.inertial, PaperOptions{});
  ASSERT_EQ(result.states.size(), data.truth.size());
  for (const State& state : result.states) {
    EXPECT_TRUE(state.nav.T_world_body.matrix().allFinite());
    EXPECT_TRUE(state.nav.v_world.allFinite());
  }
  EXPECT_LT((result.states.back().nav.T_world_body.translation() -
             data.truth.back().nav.T_world_body.translation())
                .norm(),
            0.2);
}

TEST(PaperWindows, RejectsUnknownWeights) {
  PaperOptions options;
  options.dataset = "tartanair";
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace imslam::pgo

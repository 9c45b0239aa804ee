#include "datasets/simulation/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/simulation/imu_model.hpp"
#include "datasets/simulation/scene.hpp"

namespace imslam::simulation {
namespace {

SimulationOptions options_for(const std::string& scene, const std::string& motion = "natural") {
  SimulationOptions options;
  options.scene = scene;
  options.motion = motion;
  options.textures = "procedural";
  options.duration_s = 40.0;
  return options;
}

lie::SE3d circle(double t) {
  return lie::SE3d(lie::SO3d::exp({0, 0, 0.5 * t}),
                   {2 * std::cos(0.5 * t), 2 * std::sin(0.5 * t), 1});
}

TEST(Motion, RestsBeforeItMovesAndReachesTheUsualSpeed) {
  SimulationOptions options = options_for("room");
  options.rest_s = 2.0;
  const MotionSpline motion = make_motion(options, circle);
  for (double t = 0.0; t < 1.6; t += 0.1) EXPECT_LT(motion.at(t).v_world.norm(), 1e-12) << t;
  EXPECT_GT(motion.at(3.0).v_world.norm(), 0.1);
  EXPECT_NEAR(motion.at(10.0).v_world.norm(), 1.0, 0.01);
}

TEST(Motion, FreeFallFeelsNoForceAndStaticFeelsGravityOnly) {
  const MotionSpline fall = make_motion(options_for("room", "free_fall"), circle);
  EXPECT_LT(specific_force(fall.at(3.3)).norm(), 1e-9);
  const MotionSpline still = make_motion(options_for("room", "static"), circle);
  EXPECT_NEAR(specific_force(still.at(7.0)).z(), kGravity, 1e-9);
  EXPECT_LT(still.at(7.0).omega_body.norm(), 1e-15);
}

TEST(Motion, PureRotationTurnsOnTheSpot) {
  const MotionSpline motion = make_motion(options_for("room", "pure_rotation"), circle);
  EXPECT_LT(motion.at(20.0).v_world.norm(), 1e-12);
  EXPECT_GT(motion.at(20.0).omega_body.norm(), 0.1);
}

TEST(Motion, ACarDoesNotSlideSideways) {
  const SimulationOptions options = options_for("street");
  TextureBank bank("procedural");
  const Scene scene = make_scene(options, bank, Random(2));
  const MotionSpline motion = make_motion(options, scene.path);
  double fastest = 0.0;
  for (double t = 0.0; t < 40.0; t += 0.05) {
    const MotionState state = motion.at(t);
    const Eigen::Vector3d v_body = state.T_world_body.rotation().inverse() * state.v_world;
    EXPECT_LT(std::abs(v_body.y()), 0.05) << t;
    fastest = std::max(fastest, v_body.x());
  }
  EXPECT_GT(fastest, 5.0);
  EXPECT_LT(fastest, 12.0);
}

// What a person or a drone can do, in every family and for several layouts.
TEST(Motion, StaysWithinNaturalRatesInEveryScene) {
  for (const char* scene_name : {"room", "corridor", "forest"}) {
    for (const unsigned seed : {1U, 2U, 3U}) {
      const SimulationOptions options = options_for(scene_name);
      TextureBank bank("procedural");
      const MotionSpline motion =
          make_motion(options, make_scene(options, bank, Random(seed)).path);
      double travelled = 0.0;
      for (double t = 0.0; t < 40.0; t += 0.05) {
        const MotionState state = motion.at(t);
        EXPECT_LT(state.v_world.norm(), 2.5) << scene_name << seed << " " << t;
        EXPECT_LT(state.omega_body.norm(), 2.5) << scene_name << seed << " " << t;
        EXPECT_LT(state.a_world.norm(), 8.0) << scene_name << seed << " " << t;
        travelled += 0.05 * state.v_world.norm();
      }
      EXPECT_GT(travelled, 12.0) << scene_name << seed;
    }
  }
}

}  // namespace
}  // namespace imslam::simulation

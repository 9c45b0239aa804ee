#include "datasets/simulation/options.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

std::string complaint(const SimulationOptions& options) {
  try {
    options.validate();
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    return error.what();
  }
  return "";
}

TEST(SimulationOptions, DefaultsAreValidAndSoIsTheEmbeddedSequence) {
  EXPECT_NO_THROW(SimulationOptions().validate());
  EXPECT_NO_THROW(default_sequence_options().validate());
  EXPECT_EQ(default_sequence_options().textures, "procedural");
}

TEST(SimulationOptions, AComplaintNamesKeyValueAndBound) {
  SimulationOptions options;
  options.imu.rate_hz = 5000.0;
  EXPECT_EQ(complaint(options), "simulation.imu.rate_hz = 5000: must lie in [50, 1000]");
  options = SimulationOptions();
  options.scene = "moon";
  EXPECT_EQ(complaint(options),
            "simulation.scene = 'moon': must be one of room, corridor, forest, street");
  options = SimulationOptions();
  options.duration_s = std::nan("");
  EXPECT_NE(complaint(options).find("simulation.duration_s"), std::string::npos);
}

TEST(SimulationOptions, EveryFieldCanBeSetThroughTheConfig) {
  SimulationOptions options;
  Config config;
  config.section("simulation", options);
  config.set("simulation.camera.preset=tumvi", "test");
  config.set("simulation.imu.grade=phone", "test");
  config.set("simulation.image.exposure_ms=12.5", "test");
  EXPECT_EQ(options.camera.preset, "tumvi");
  EXPECT_EQ(options.imu.grade, "phone");
  EXPECT_DOUBLE_EQ(options.image.exposure_ms, 12.5);
  EXPECT_THROW(config.set("simulation.imu.grade=golden", "test"), InputError);
}

}  // namespace
}  // namespace imslam::simulation

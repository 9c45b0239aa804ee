#include "datasets/simulation/options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "slam/base/config.hpp"
#include "slam/base/error.hpp"

namespace imslam::simulation {
namespace {

/// low <= value <= high, or a message that names key, value and bounds.
void within(const char* key, double value, double low, double high) {
  if (std::isfinite(value) && value >= low && value <= high) return;
  throw InputError(fmt::format("simulation.{} = {}: must lie in [{}, {}]", key, value, low, high),
                   ExitCode::kUsage);
}

void zero_or_within(const char* key, double value, double low, double high) {
  if (value != 0.0) within(key, value, low, high);
}

void one_of(const char* key, const std::string& value, const std::vector<std::string>& allowed) {
  for (const std::string& name : allowed) {
    if (name == value) return;
  }
  throw InputError(
      fmt::format("simulation.{} = '{}': must be one of {}", key, value, fmt::join(allowed, ", ")),
      ExitCode::kUsage);
}

const std::vector<std::string> kPresets = {"euroc", "tumvi", "kitti"};
const std::vector<std::string> kGrades = {"perfect", "tactical", "industrial", "mems", "phone"};
const std::vector<std::string> kScenes = {"room", "corridor", "forest", "street"};
const std::vector<std::string> kMotions = {"natural", "static", "pure_rotation", "free_fall"};
const std::vector<std::string> kTextures = {"procedural", "photos", "auto"};

}  // namespace

void CameraOptions::describe(Config& config) {
  config.field("preset", preset, kPresets, "lens and baseline of a known stereo head");
  config.field("width", width, "image width [px], 0: of the preset");
  config.field("height", height, "image height [px], 0: of the preset");
  config.field("focal_scale", focal_scale, "times the preset's focal length");
  config.field("distortion_scale", distortion_scale, "times the preset's distortion, 0: none");
  config.field("baseline_m", baseline_m, "distance of the cameras [m], 0: of the preset");
  config.field("misalignment_deg", misalignment_deg, "sigma of the rotation left to right [deg]");
  config.field("mounting_deg", mounting_deg, "sigma of the rotation body to camera [deg]");
}

void CameraOptions::validate() const {
  one_of("camera.preset", preset, kPresets);
  zero_or_within("camera.width", width, 32, 8192);
  zero_or_within("camera.height", height, 32, 8192);
  within("camera.focal_scale", focal_scale, 0.3, 5.0);
  within("camera.distortion_scale", distortion_scale, 0.0, 1.0);
  zero_or_within("camera.baseline_m", baseline_m, 0.01, 2.0);
  within("camera.misalignment_deg", misalignment_deg, 0.0, 3.0);
  within("camera.mounting_deg", mounting_deg, 0.0, 10.0);
}

void ImageOptions::describe(Config& config) {
  config.field("exposure_ms", exposure_ms, "exposure time, decides motion blur [ms]");
  config.field("auto_exposure", auto_exposure, "gain follows the mean brightness");
  config.field("exposure_steps", exposure_steps, "sudden gain changes per minute");
  config.field("brightness", brightness, "mean brightness aimed at, of full scale");
  config.field("right_gain_percent", right_gain_percent, "sigma of the right camera's gain error");
  config.field("vignetting", vignetting, "share of light lost in the corners");
  config.field("noise_scale", noise_scale, "times shot and read noise, 0: none");
  config.field("read_noise", read_noise, "sigma of the read noise [grey levels]");
  config.field("shot_noise", shot_noise, "variance of the shot noise per grey level");
}

void ImageOptions::validate() const {
  within("image.exposure_ms", exposure_ms, 0.0, 50.0);
  within("image.exposure_steps", exposure_steps, 0.0, 600.0);
  within("image.brightness", brightness, 0.02, 0.95);
  within("image.right_gain_percent", right_gain_percent, 0.0, 30.0);
  within("image.vignetting", vignetting, 0.0, 0.9);
  within("image.noise_scale", noise_scale, 0.0, 50.0);
  within("image.read_noise", read_noise, 0.0, 50.0);
  within("image.shot_noise", shot_noise, 0.0, 10.0);
}

void ImuOptions::describe(Config& config) {
  config.field("grade", grade, kGrades, "typical errors of a class of sensors");
  config.field("rate_hz", rate_hz, "samples per second");
  config.field("noise_scale", noise_scale, "times white noise and bias walk");
  config.field("bias_scale", bias_scale, "times the initial bias");
  config.field("shape_scale", shape_scale, "times scale factor and misalignment errors");
  config.field("g_sensitivity_scale", g_sensitivity_scale,
               "times the gyro's error per specific force, 1: of the grade");
  config.field("temperature_scale", temperature_scale,
               "times the change of bias while warming up, 1: of the grade");
  config.field("vibration", vibration, "rms per axis while the vehicle runs [m/s^2]");
  config.field("gyro_range", gyro_range, "saturation [rad/s], 0: of the grade");
  config.field("accel_range", accel_range, "saturation [m/s^2], 0: of the grade");
  config.field("quantise", quantise, "round to the steps of a 16-bit sensor");
  config.field("camera_delay_s", camera_delay_s, "t_imu = t_camera + camera_delay_s [s]");
}

void ImuOptions::validate() const {
  one_of("imu.grade", grade, kGrades);
  within("imu.rate_hz", rate_hz, 50.0, 1000.0);
  within("imu.noise_scale", noise_scale, 0.0, 100.0);
  within("imu.bias_scale", bias_scale, 0.0, 100.0);
  within("imu.shape_scale", shape_scale, 0.0, 100.0);
  within("imu.g_sensitivity_scale", g_sensitivity_scale, 0.0, 100.0);
  within("imu.temperature_scale", temperature_scale, 0.0, 100.0);
  within("imu.vibration", vibration, 0.0, 50.0);
  zero_or_within("imu.gyro_range", gyro_range, 0.1, 100.0);
  zero_or_within("imu.accel_range", accel_range, 10.0, 1000.0);
  within("imu.camera_delay_s", camera_delay_s, -0.2, 0.2);
}

void SimulationOptions::describe(Config& config) {
  config.field("scene", scene, kScenes, "scene family");
  config.field("motion", motion, kMotions, "natural: as fits the scene; the others are for tests");
  config.field("textures", textures, kTextures,
               "procedural: the same everywhere; photos: of installed packages");
  config.field("seed", seed, "decides layout, motion and noise");
  config.field("duration_s", duration_s, "length of the sequence [s]");
  config.field("rest_s", rest_s, "standing still at the start [s]");
  config.field("speed", speed, "times the usual speed of the scene family");
  config.field("frame_rate_hz", frame_rate_hz, "stereo pairs per second");
  config.field("dynamic_objects", dynamic_objects, "cars that drive");
  config.field("antialias", antialias, "extra rays at edges");
  config.field("truth_depth", truth_depth, "write the left camera's depth");
  config.field("truth_flow", truth_flow, "write the left camera's optical flow");
  config.field("drop_left_percent", drop_left_percent, "left images that are missing");
  config.field("drop_right_percent", drop_right_percent, "right images that are missing");
  config.field("force", force, "write into a folder that is not empty");
  config.section("camera", camera);
  config.section("image", image);
  config.section("imu", imu);
}

void SimulationOptions::validate() const {
  one_of("scene", scene, kScenes);
  one_of("motion", motion, kMotions);
  one_of("textures", textures, kTextures);
  within("seed", seed, 0, 2147483647);
  within("duration_s", duration_s, 0.1, 36000.0);
  within("rest_s", rest_s, 0.0, 60.0);
  within("speed", speed, 0.1, 4.0);
  within("frame_rate_hz", frame_rate_hz, 1.0, 200.0);
  within("drop_left_percent", drop_left_percent, 0.0, 90.0);
  within("drop_right_percent", drop_right_percent, 0.0, 90.0);
  camera.validate();
  image.validate();
  imu.validate();
}

SimulationOptions default_sequence_options() {
  SimulationOptions options;
  options.textures = "procedural";
  return options;
}

}  // namespace imslam::simulation

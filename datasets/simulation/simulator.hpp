#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/simulation/imu_model.hpp"
#include "datasets/simulation/motion_spline.hpp"
#include "datasets/simulation/options.hpp"
#include "datasets/simulation/rig.hpp"
#include "slam/sensors/stereo.hpp"

namespace imslam::simulation {

/// A raw (distorted) stereo pair and what is true of it. Truth belongs to the left image's pixel
/// centres; row major.
struct SimulatedFrame {
  double time_s = 0.0;       ///< middle of the exposure, since the start of the motion
  std::int64_t time_ns = 0;  ///< stamp of the camera's clock
  int width = 0;             ///< [px] of the left image
  int height = 0;
  GrayImage left;
  GrayImage right;
  MotionState truth;         ///< of the body
  std::vector<float> depth;  ///< [m] along the optical axis, 0: sky; empty unless asked for
  std::vector<float> flow;   ///< [px] column, row change to `flow_to_s`, interleaved; or empty
  std::vector<std::uint8_t> flow_valid;  ///< 1: the point lies inside the left image at flow_to_s
};

struct FrameRequest {
  bool depth = false;
  std::optional<double> flow_to_s;  ///< time [s] at which the left camera looks again
};

/// A simulated stereo-inertial sensor in a simulated world, in memory.
///
/// Any instant may be asked for, in any order; the answer depends on options and time only.
class Simulator {
 public:
  /// Validates the options and builds the world (a second or so).
  explicit Simulator(const SimulationOptions& options);
  ~Simulator();
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;

  const SimulationOptions& options() const;
  const StereoRig& rig() const;
  const MotionSpline& motion() const;
  const ImuErrors& imu_errors() const;
  std::string texture_bank() const;  ///< which textures were used, for the record

  std::size_t frame_count() const;
  double frame_time_s(std::size_t index) const;

  /// One caller at a time; parallel inside.
  SimulatedFrame render(double time_s, const FrameRequest& request = {});

  /// A fresh stream of readings from the start; always the same one.
  ImuModel imu() const;
  std::size_t imu_count() const;

  /// Stamp of the IMU's clock for a time since the start of the motion.
  std::int64_t stamp_ns(double time_s) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace imslam::simulation

#pragma once

#include <Eigen/Core>
#include <array>

#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// How much the readings shake beyond the noise that the sensor is said to have: an engine, a road,
/// rotors. What a camera does not see of it, or what the rate of the sensor is too slow for, counts
/// as white noise of the same strength. From the past only.
///
/// Of a smooth motion third differences of neighbouring readings leave next to nothing, a share of
/// (2 pi f / rate)^3 of an oscillation at f [Hz]; white noise of variance s^2 leaves 20 s^2. Their
/// mean over about half a second, minus the stated variance, is what is added.
class VibrationMeter {
 public:
  /// `noise`: stated, per axis; its rate tells neighbours from gaps.
  explicit VibrationMeter(const ImuNoise& noise) : noise_(noise) {}

  /// The reading with what it shakes added to its variances. Readings that are not usable, and the
  /// first three after a gap, tell nothing. Stamps must increase.
  ImuSample add(const ImuSample& sample);

 private:
  using Axes = Eigen::Array<double, 6, 1>;  ///< gyro, accelerometer

  void look_at(const Axes& reading);

  ImuNoise noise_;
  std::array<Axes, 3> last_{Axes::Zero(), Axes::Zero(), Axes::Zero()};  ///< the newest first
  int in_a_row_ = 0;  ///< usable neighbours up to now
  std::int64_t last_ns_ = 0;
  int looked_ = 0;
  Axes variance_ = Axes::Zero();  ///< of a reading
};

}  // namespace imslam::imu

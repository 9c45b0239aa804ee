#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// How much the readings shake beyond the noise that the sensor is said to have: an engine, a road,
/// rotors. What is too slow to average out between two frames counts as white noise of the same
/// strength. From the past only.
///
/// Readings are averaged over bins of 1, 2, 4, ... samples, up to about the time between frames. Of
/// a smooth motion third differences of neighbouring bins leave next to nothing, a share of
/// (2 pi f bin)^3 of an oscillation at f [Hz]; white noise of variance s^2 per sample leaves
/// 20 s^2 / n in bins of n. So each length of bins bounds the noise from above: long bins see the
/// motion itself, short ones the shaking of rotors, fast and bounded, which integrates to nothing
/// (on EuRoC's flights ten times less in bins of two than in bins of one). The lowest bound, minus
/// the stated variance, is what is added.
class VibrationMeter {
 public:
  /// `noise`: stated, per axis; its rate tells neighbours from gaps.
  explicit VibrationMeter(const ImuNoise& noise);

  /// The reading with what it shakes added to its variances. Readings that are not usable, and the
  /// first bins after a gap, tell nothing. Stamps must increase.
  ImuSample add(const ImuSample& sample);

 private:
  using Axes = Eigen::Array<double, 6, 1>;  ///< gyro, accelerometer

  /// One length of bins.
  struct Scale {
    int length = 1;  ///< [samples]
    int filled = 0;  ///< of the bin that is being filled
    Axes sum = Axes::Zero();
    std::array<Axes, 3> last{Axes::Zero(), Axes::Zero(), Axes::Zero()};  ///< the newest first
    int in_a_row = 0;                                                    ///< bins up to now
    int looked = 0;
    Axes variance = Axes::Zero();  ///< of a reading, if its noise is white
  };

  void look_at(const Axes& reading, Scale& scale) const;
  void close_bin(const Axes& mean, Scale& scale) const;
  Axes lowest_bound() const;
  double scatter_of(const Scale& scale) const;  ///< [1] of its variance

  ImuNoise noise_;
  Axes stated_;  ///< variance of a reading
  std::vector<Scale> scales_;
  std::int64_t last_ns_ = 0;
};

}  // namespace imslam::imu

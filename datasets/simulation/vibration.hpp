#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/base/random.hpp"

namespace imslam::simulation {

/// How hard the vehicle shakes from `time_s` on; linear in between, constant before and after.
struct VibrationLevel {
  double time_s = 0.0;     ///< since the start of the motion
  double tones = 0.0;      ///< times the amplitude: rotors, engine
  double broadband = 0.0;  ///< likewise: road, air
};

/// What rotors, engine and road add to the readings of a sensor that is bolted to them: a few
/// tones of 20 to 200 Hz whose frequency and amplitude wander slowly, and noise above 20 Hz.
///
///   vibration = amplitude (level_tones sum_k a_k(t) g_k cos phi_k(t) + level_broadband H n)
///
/// g_k: random gains and phases per axis; H: high-pass at 20 Hz, because a body that stays where it
/// is has no slow acceleration; tones above the sensor's low-pass (0.4 of its rate, second order)
/// are weakened and appear at their alias. It is a disturbance of the readings: its path is a few
/// micrometres long and no part of the true motion.
class Vibration {
 public:
  struct Reading {
    Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< [rad/s]
    Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< [m/s^2]
  };

  /// `amplitude` [m/s^2]: about the rms per axis at level 1. `levels`: in order of time; none:
  /// the vehicle never runs.
  Vibration(double amplitude,
            double rate_hz,
            std::vector<VibrationLevel> levels,
            const Random& random);

  /// Of the next sample, 1 / rate_hz after the last one; `time_s` since the start of the motion.
  Reading next(double time_s);

 private:
  using Axes = Eigen::Matrix<double, 6, 1>;  ///< accel [m/s^2], gyro [rad/s]
  struct Tone {
    double hertz = 0.0;
    double frequency_wander = 0.0;  ///< logarithms of the present factors
    double amplitude_wander = 0.0;
    Axes cosine_gain = Axes::Zero();
    Axes sine_gain = Axes::Zero();
    std::complex<double> phase{1.0, 0.0};
    std::complex<double> turn{1.0, 0.0};  ///< per sample
    double gain = 1.0;
  };

  void wander();
  VibrationLevel level_at(double time_s);
  Axes noise();

  double rate_hz_;
  std::vector<VibrationLevel> levels_;
  std::size_t cursor_ = 0;  ///< of the level that lies ahead
  Random random_;
  std::array<Tone, 4> tones_;
  Axes noise_gain_;
  double high_pass_;
  Axes last_white_ = Axes::Zero();
  Axes high_passed_ = Axes::Zero();
  std::int64_t block_;  ///< [samples] between two steps of the wandering
  std::int64_t count_ = 0;
};

}  // namespace imslam::simulation

#pragma once

namespace imslam {
class Config;
}

namespace imslam::training {

/// Which inertial logs are made up: who carries the sensor and how bad it is. The scales are for
/// experiments and tests; 0 leaves an error out.
struct InertialLogOptions {
  int seed = 1;
  double drone_share = 0.4;  ///< the four shares are relative to their sum
  double hand_share = 0.25;
  double car_share = 0.2;
  double rover_share = 0.15;
  double min_duration_s = 20.0;      ///< [s]
  double max_duration_s = 120.0;     ///< [s]
  double rate_hz = 0.0;              ///< [Hz] of the samples, 0: drawn from 50 to 1000
  double noise_scale = 1.0;          ///< times white noise and bias walk
  double bias_scale = 1.0;           ///< times the initial bias
  double shape_scale = 1.0;          ///< times scale and misalignment errors
  double g_sensitivity_scale = 1.0;  ///< times the gyro's error per specific force
  double temperature_scale = 1.0;    ///< times the change of bias while warming up
  double vibration_scale = 1.0;      ///< times what rotors, engine and road add
  double quantised_share = 0.3;      ///< of logs whose readings are rounded to 16 bits
  double jitter_share = 0.3;         ///< of logs with jittered stamps, up to 10 % of a period
  double gap_share = 0.15;           ///< of logs with gaps of 0.05 to 1 s

  void describe(Config& config);
  void validate() const;  ///< throws InputError(kUsage)
};

}  // namespace imslam::training

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "imu_net/imu_buffer.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam {
class Config;
}

namespace imslam::imu {

struct StaticDetectorOptions {
  double bin_s = 0.1;              ///< [s] readings are averaged over bins: vibration is not motion
  double max_rate_spread = 0.01;   ///< [rad/s] standard deviation of the bins' means, per axis
  double max_force_spread = 0.08;  ///< [m/s^2] likewise
  double max_rate = 0.15;          ///< [rad/s] mean rate; what is more cannot be bias alone
  double max_gravity_error = 0.5;  ///< [m/s^2] of the mean specific force against 9.81
  double noise_factor = 4.0;       ///< spreads may also be this many times the datasheet's noise

  void describe(Config& config);
  void validate() const;  ///< throws InputError(kUsage)
};

/// What the readings of one window say; means and spreads are those of the bins.
struct Stillness {
  bool still = false;
  int bins = 0;  ///< with usable readings; 0: the rest is meaningless
  Eigen::Vector3d mean_rate = Eigen::Vector3d::Zero();     ///< [rad/s]
  Eigen::Vector3d mean_force = Eigen::Vector3d::Zero();    ///< [m/s^2]
  Eigen::Vector3d rate_spread = Eigen::Vector3d::Zero();   ///< [rad/s]
  Eigen::Vector3d force_spread = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// Means over one bin, [rate force].
using BinMean = Eigen::Matrix<double, 6, 1>;

/// Whether the body rests during bins of options.bin_s; `means`: of those with usable readings, out
/// of `wanted`.
Stillness assess_bins(const std::vector<BinMean>& means,
                      double wanted,
                      const ImuNoise& noise,
                      const StaticDetectorOptions& options = {});

/// Whether the body rests between two IMU times: slow changes are small, the force is gravity's.
///
/// An IMU cannot tell rest from smooth straight travel; where vision is at hand it must agree.
/// Readings that are not finite or reach the range are left out; a window with more than a fifth
/// of its bins empty is not still.
Stillness assess_stillness(ImuRange samples,
                           std::int64_t time0_ns,
                           std::int64_t time1_ns,
                           const ImuNoise& noise,
                           const StaticDetectorOptions& options = {});

}  // namespace imslam::imu

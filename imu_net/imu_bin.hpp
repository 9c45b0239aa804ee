#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// The readings of one tenth of a second, whatever the sensor's rate.
struct ImuBin {
  static constexpr std::int64_t kLength_ns = 100'000'000;
  static constexpr double kLength_s = 0.1;

  std::int64_t end_ns = 0;
  int count = 0;  ///< usable readings; 0: the means are those of the bin before
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   ///< mean [rad/s]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< mean [m/s^2]

  /// Noise density that white noise of the seen strength would have, from the differences of
  /// neighbouring readings; vibration counts.
  Eigen::Vector3d gyro_density = Eigen::Vector3d::Zero();   ///< [rad/s/sqrt(Hz)]
  Eigen::Vector3d accel_density = Eigen::Vector3d::Zero();  ///< [m/s^2/sqrt(Hz)]
};

/// Sorts readings into bins as they come.
class BinAccumulator {
 public:
  explicit BinAccumulator(const ImuNoise& noise) : noise_(noise) {}

  /// The bins that this reading closes: none, one, or after a gap several. Of a long gap only the
  /// last kLongestGap bins are reported (`end_ns` leaps), so that work stays bounded.
  const std::vector<ImuBin>& add(const ImuSample& sample);

  static constexpr std::int64_t kLongestGap = 20;  ///< [bins]

 private:
  void close();

  ImuNoise noise_;
  std::vector<ImuBin> closed_;
  ImuBin open_;
  std::optional<ImuSample> previous_;                      ///< the last usable reading
  Eigen::Vector3d rate_square_ = Eigen::Vector3d::Zero();  ///< of differences, times their length
  Eigen::Vector3d force_square_ = Eigen::Vector3d::Zero();
  int differences_ = 0;
  bool begun_ = false;
};

}  // namespace imslam::imu

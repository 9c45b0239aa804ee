#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "imu_net/bias_observers.hpp"
#include "imu_net/imu_bin.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// What the network sees at the end of one bin.
///
/// Features belong to an axis and are even: they do not change if the axis is turned round. With
/// one network for all axes the answer then follows the sensor however it is mounted. Logarithms of
/// what varies over decades; all within about -2 and 2.
struct ImuFrame {
  static constexpr int kFeatures = 36;
  static constexpr int kGyroCandidates = 4;   ///< rest, gravity (two), mean
  static constexpr int kAccelCandidates = 1;  ///< rest

  std::int64_t time_ns = 0;  ///< from here on the answer holds
  std::array<std::array<float, kFeatures>, 3> features{};
  std::array<Eigen::Vector3d, kGyroCandidates> gyro_bias{};    ///< [rad/s]
  std::array<Eigen::Vector3d, kAccelCandidates> accel_bias{};  ///< [m/s^2]
};

class FeatureWriter;

/// Raw readings in, frames out: causal, at any rate. State of fixed size.
class FeatureExtractor {
 public:
  explicit FeatureExtractor(const ImuNoise& noise);

  /// The frames that this reading completes; see BinAccumulator::add().
  const std::vector<ImuFrame>& add(const ImuSample& sample);

 private:
  ImuFrame describe(const ImuBin& bin, double dt_s);
  /// `rate`: without the bias.
  void put_motion(const ImuBin& bin,
                  const Eigen::Vector3d& rate,
                  int axis,
                  FeatureWriter& out) const;

  ImuNoise noise_;
  BinAccumulator bins_;
  RestObserver rest_;
  GravityObserver gravity_;        ///< trusts gravity slowly
  GravityObserver quick_gravity_;  ///< and quickly
  MeanObserver mean_;
  std::vector<ImuFrame> frames_;
  std::int64_t start_ns_ = 0;
  std::int64_t last_end_ns_ = 0;
  bool begun_ = false;
  ImuBin previous_;
  Eigen::Vector3d rate_square_ = Eigen::Vector3d::Zero();  ///< about the mean, last seconds
  double force_square_ = 0.0;                              ///< of |force| - g, last seconds
};

}  // namespace imslam::imu

#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "imu_net/imu_bin.hpp"
#include "imu_net/static_detector.hpp"
#include "slam/lie/so3.hpp"

namespace imslam::imu {

/// What one observer believes: bias and standard deviation, axis by axis.
struct BiasBelief {
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
};

/// A reading of the gyro bias itself.
struct RestReading {
  Eigen::Vector3d rate;      ///< [rad/s]
  Eigen::Vector3d variance;  ///< per axis
};

/// Gyro bias from rest: then the reading is the bias. Also the accelerometer's, as far as rest
/// shows it: |force - bias| = g, one axis per attitude.
///
/// A bin counts once the second around it was still (it lies in the past then), so that the moments
/// before a start do not. A Kalman filter per axis; biases wander as the datasheet says, and warm
/// up.
class RestObserver {
 public:
  explicit RestObserver(const ImuNoise& noise);

  void add(const ImuBin& bin, double dt_s);

  BiasBelief gyro() const { return {gyro_, gyro_variance_.cwiseSqrt()}; }
  BiasBelief accel() const { return {accel_, accel_covariance_.diagonal().cwiseSqrt()}; }
  bool still() const { return reading_.has_value(); }
  /// What the last bin has taught; none unless still.
  const std::optional<RestReading>& reading() const { return reading_; }
  double time_since_rest_s() const { return since_rest_s_; }  ///< since the start if never

 private:
  void learn(const BinMean& bin, const Stillness& rest);

  ImuNoise noise_;
  std::deque<BinMean> recent_;  ///< a second of bins
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_variance_;
  Eigen::Vector3d accel_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d accel_covariance_;
  std::optional<RestReading> reading_;
  double since_rest_s_ = 0.0;
};

/// Gyro bias from rest and gravity together: in the long run the accelerometer shows where up is.
/// An error-state Kalman filter of attitude (heading is free) and bias; accelerations are its
/// noise.
///
///   R' = R Exp((w - b) h)       measured: direction of the force = R^T e_z, at rest also b
class GravityObserver {
 public:
  /// What accelerations look like. No value suits a hand and a drone, whose thrust hides its tilt.
  struct Accelerations {
    double least = 0.5;         ///< [m/s^2] that do not show in |force|
    double correlation = 40.0;  ///< [bins] for which they last
  };

  GravityObserver(const ImuNoise& noise, const Accelerations& accelerations);

  void add(const ImuBin& bin, double dt_s, const std::optional<RestReading>& rest);

  BiasBelief gyro() const { return {bias_, P_.diagonal().tail<3>().cwiseSqrt()}; }

 private:
  void predict(const Eigen::Vector3d& rate, double dt_s);
  void correct(const Eigen::Vector3d& force);
  void rest(const RestReading& reading);
  /// The Kalman update of a measurement of three numbers.
  void update(const Eigen::Matrix<double, 3, 6>& H,
              const Eigen::Vector3d& residual,
              const Eigen::Vector3d& variance);

  ImuNoise noise_;
  Accelerations accelerations_;
  bool begun_ = false;
  lie::SO3d R_level_body_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 6, 6> P_;  ///< of [attitude, right; bias]
};

/// Gyro bias from the long run: a body that turns to and fro has a mean rate of zero. Also how much
/// it turns. The last two minutes count.
class MeanObserver {
 public:
  void add(const ImuBin& bin);

  BiasBelief gyro() const;
  Eigen::Vector3d rate_rms() const { return variance_.cwiseSqrt(); }  ///< about the mean [rad/s]

 private:
  double count_ = 0.0;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d variance_ = Eigen::Vector3d::Zero();
};

}  // namespace imslam::imu

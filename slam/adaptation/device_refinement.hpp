#pragma once

#include <Eigen/Core>
#include <optional>

#include "slam/adaptation/adaptation_options.hpp"
#include "slam/sensors/device_calibration.hpp"
#include "slam/system/slam_result.hpp"

namespace imslam::adaptation {

/// How the camera is turned against the body beyond what the run assumed, R = assumed
/// Exp(rotation).
struct CameraRotation {
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();  ///< [rad]
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();     ///< [rad]
};

/// One Newton step on
///
///   U(delta) = min over states of L(states, motions seen through a camera turned by delta)
///              + |delta|^2 / (2 prior_sigma^2)
///
/// dU/ddelta is the one-step gradient (the states do not count at a solution); its derivative
/// follows from solutions a little aside. Empty: the graph has no IMU to compare with, or does not
/// converge aside.
std::optional<CameraRotation> camera_rotation(const system::SlamResult& result,
                                              const lie::SE3d& T_body_left,
                                              double prior_sigma);

/// The device as a run's solution has it. What the graph did not estimate, or hardly better than
/// was known before, stays as the run assumed it, as does what `options` hold: with a regression
/// head that learns, the offset of disparities makes up for its errors and runs away with it. The
/// numbers are kept within DeviceBounds; `assumed` is what the run began with, `stated` the camera
/// without it.
///
/// A gyro whose scale is off by a percent, as those of phones are, looks like a focal length that
/// is, and one whose axes are askew like a turned camera: only a gyro that is known for small
/// biases (options.trusted_gyro_bias) may correct these two.
DeviceCalibration refined_device(const system::SlamResult& result,
                                 const DeviceCalibration& assumed,
                                 const StereoCamera& stated,
                                 const std::optional<ImuNoise>& imu,
                                 const system::SlamOptions& slam,
                                 const AdaptationOptions& options);

}  // namespace imslam::adaptation

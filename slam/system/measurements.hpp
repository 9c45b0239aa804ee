#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "imu_net/imu_buffer.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::system {

/// What a correction is surest of about the bias of one axis.
struct BiasBelief {
  int axis = 0;  ///< 0 to 2: gyro, 3 to 5: accelerometer
  std::int64_t time_ns = 0;
  double bias = 0.0;   ///< [rad/s], [m/s^2]
  double sigma = 0.0;  ///< standard deviation
};

/// What the front ends have measured: all that the graph needs. Grows by about 0.5 kB per frame,
/// and by the inertial readings unless somebody lends them.
struct Measurements {
  std::vector<std::int64_t> times_ns;    ///< of all frames, strictly increasing
  std::vector<RelativeMotion> odometry;  ///< from one measured frame to the next, in order
  std::vector<RelativeMotion> skips;     ///< over several frames, any order

  lie::SE3d T_body_left;  ///< by which the motions came from camera to body

  std::vector<ImuSample> imu;  ///< strictly increasing stamps; empty: no IMU, or see lend_imu()
  imu::ImuRange lent_imu;      ///< instead of `imu`
  ImuNoise imu_noise;
  double gyro_shape_sigma = 0.0;         ///< [1] of each scale and axis of the gyro; 0: as stated
  std::vector<BiasBelief> bias_beliefs;  ///< one per axis and sensor, or none

  /// Appends a reading that its owner keeps where it is. As long as each lies behind the one before
  /// in memory, none is copied.
  void lend_imu(const ImuSample& kept);
  /// Appends a reading that nobody else keeps; those lent before are copied.
  void keep_imu(const ImuSample& reading);
  /// All readings, own or lent.
  imu::ImuRange readings() const { return lent_imu.empty() ? imu::ImuRange(imu) : lent_imu; }

  /// Index of the frame with this stamp; empty if there is none. Binary search.
  std::optional<std::size_t> frame_at(std::int64_t time_ns) const;
};

/// Poses of all frames from visual odometry alone; the first is identity.
///
/// Frames inside a motion that spans several intervals lie on its screw motion; where nothing was
/// measured the last motion goes on at its rate (`covered` is false there).
struct OdometryChain {
  Trajectory trajectory;
  std::vector<bool> covered;  ///< per frame: reached by measurements from the frame before
};
OdometryChain chain_odometry(const Measurements& measurements);

/// An edge for a step that nothing measured: the trajectory's own step from `to` - 1 to `to`, sure
/// only to 1 m/s and 0.5 rad/s. It keeps the graph in one piece.
RelativeMotion bridge(const Trajectory& trajectory, std::size_t to);

}  // namespace imslam::system

#pragma once

#include "pgo/graph_data.hpp"
#include "slam/base/random.hpp"
#include "slam/base/time.hpp"
#include "slam/system/measurements.hpp"
#include "tests/imu_net/synthetic_motion.hpp"

namespace imslam::system::testing {

/// What perfect front ends would measure of a body that sways along sines.
struct SineWorld {
  imu::testing::SineMotion motion;
  double duration_s = 6.0;
  double frame_rate_hz = 20.0;
  double imu_rate_hz = 200.0;
  double time_offset_s = 0.0;  ///< t_imu = t_camera + time_offset
  double sigma_translation = 1e-4;
  double sigma_rotation = 1e-4;

  lie::SE3d pose(std::int64_t camera_time_ns) const {
    return motion.state(to_seconds(camera_time_ns - imu::testing::kOrigin_ns)).T_world_body;
  }

  Measurements measure() const {
    Measurements measurements;
    const auto frames = static_cast<int>(duration_s * frame_rate_hz) + 1;
    for (int i = 0; i < frames; ++i) {
      measurements.times_ns.push_back(imu::testing::stamp(i / frame_rate_hz));
    }
    for (std::size_t i = 1; i < measurements.times_ns.size(); ++i) {
      measurements.odometry.push_back(step(measurements.times_ns[i - 1], measurements.times_ns[i]));
    }
    measurements.imu = motion.samples(-0.5, duration_s + 0.5, imu_rate_hz);
    for (ImuSample& sample : measurements.imu) sample.time_ns += to_nanoseconds(time_offset_s);
    measurements.imu_noise.rate_hz = imu_rate_hz;
    return measurements;
  }

  RelativeMotion step(std::int64_t time0_ns, std::int64_t time1_ns) const {
    RelativeMotion result;
    result.time0_ns = time0_ns;
    result.time1_ns = time1_ns;
    result.T_body0_body1 = pose(time0_ns).inverse() * pose(time1_ns);
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << Eigen::Vector3d::Constant(sigma_translation),
        Eigen::Vector3d::Constant(sigma_rotation);
    result.covariance = sigma.cwiseAbs2().asDiagonal();
    result.valid = true;
    return result;
  }

  /// Largest distance [m] between estimate and truth after laying first pose on first pose.
  double largest_error(const Trajectory& estimate) const {
    double largest = 0.0;
    const lie::SE3d T = pose(estimate.times_ns[0]) * estimate.poses[0].inverse();
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      const Eigen::Vector3d p = (T * estimate.poses[i]).translation();
      largest = std::max(largest, (p - pose(estimate.times_ns[i]).translation()).norm());
    }
    return largest;
  }
};

inline Trajectory trajectory_of(const std::vector<pgo::State>& states) {
  Trajectory trajectory;
  for (const pgo::State& state : states) trajectory.add(state.time_ns, state.nav.T_world_body);
  return trajectory;
}

}  // namespace imslam::system::testing

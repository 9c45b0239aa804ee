#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "imu_net/imu_buffer.hpp"
#include "slam/lie/nav_state.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam {
class Config;
}

namespace imslam::imu {

struct PreintegrationRecord;

struct PreintegrationOptions {
  double max_gap_s = 0.05;    ///< [s] a longer stretch without samples marks the motion degraded
  double max_bridge_s = 2.0;  ///< [s] a longer one makes it invalid
  double max_step_s = 0.02;   ///< [s] longer segments are cut for the midpoint rule
  double gap_correlation_s =
      0.2;                    ///< [s] time over which unseen motion stops resembling the last seen
  double gap_strength = 0.4;  ///< unseen motion in long gaps, relative to the seen
  double gap_gyro_floor = 0.1;   ///< [rad/s] motion to expect in a gap even after standing still
  double gap_accel_floor = 0.5;  ///< [m/s^2] likewise

  void describe(Config& config);
  void validate() const;  ///< throws InputError(kUsage)
};

/// Integrates the samples between two camera stamps (Forster et al., TRO 2017; midpoint rule).
///
///   dR' = dR Exp(w h),   dv' = dv + M a h,   dp' = dp + dv h + M a h^2 / 2,   M = dR Exp(w h / 2)
///
/// w, a: reading minus bias, averaged over the two ends of each step of length h [s]. The interval
/// is [time0, time1] + time_offset_s in IMU time; readings at its ends are interpolated linearly.
/// J_time_offset and the bias Jacobians are exact derivatives of these sums. White noise of a step,
/// per axis: (density^2 + mean of the added variances at its two ends) / h.
///
/// Readings that are not finite, reach the range of the sensor or state a negative variance are
/// dropped. What is not seen is interpolated between its two neighbours, or held where there is
/// only one. There the covariance grows with the length of the gap and with the strength of the
/// motion around it, as for an unknown rate and specific force (constant plus ramp; see
/// gap_model.hpp), and with the number of intervals that share the gap.
///   degraded   a gap > max_gap_s or a saturated reading was bridged
///   !valid     a gap > max_bridge_s or no usable reading: zero motion, covariance 1e6 I
///
/// `record` takes what preintegration_gradient.hpp needs.
/// Throws ContractError unless time0_ns < time1_ns and |time_offset_s| <= 1000.
ImuMotion preintegrate(ImuRange samples,
                       std::int64_t time0_ns,
                       std::int64_t time1_ns,
                       const ImuBias& bias,
                       const ImuNoise& noise,
                       double time_offset_s = 0.0,
                       const PreintegrationOptions& options = {},
                       PreintegrationRecord* record = nullptr);

/// The motion as it would be with another bias, to first order:
/// dR Exp(J_dR_bias d), dv + J_dv_bias d, dp + J_dp_bias d,   d = new_bias - motion.bias.
ImuMotion correct_for_bias(const ImuMotion& motion, const ImuBias& new_bias);

/// The motion as it would be with another camera-IMU time offset, to first order.
ImuMotion correct_for_time_offset(const ImuMotion& motion, double new_time_offset_s);

/// Where the motion leads: R0 dR, v0 + g dt + R0 dv, p0 + v0 dt + g dt^2 / 2 + R0 dp.
/// gravity_world [m/s^2] points down, e.g. (0, 0, -9.81).
lie::NavState predict(const lie::NavState& state0,
                      const ImuMotion& motion,
                      const Eigen::Vector3d& gravity_world);

/// The motion that leads from state0 to state1: inverse of predict(). Only times, dt_s = `dt_s`,
/// dR, dv, dp are set.
ImuMotion motion_between(const lie::NavState& state0,
                         const lie::NavState& state1,
                         double dt_s,
                         const Eigen::Vector3d& gravity_world);

/// [dR dv dp] of `motion` minus that of `reference`; rotation: Log(dR_ref^T dR).
Eigen::Matrix<double, 9, 1> difference(const ImuMotion& motion, const ImuMotion& reference);

}  // namespace imslam::imu

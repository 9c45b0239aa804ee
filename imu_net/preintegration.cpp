#include "imu_net/preintegration.hpp"

#include <cmath>

#include "imu_net/interval_walk.hpp"
#include "imu_net/option_bounds.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

constexpr double kUnknownVariance = 1e6;
constexpr double kLargestOffset_s = 1e3;

}  // namespace

void PreintegrationOptions::describe(Config& config) {
  config.field("max_gap_s", max_gap_s, "longest gap of the IMU that is not marked degraded [s]");
  config.field("max_bridge_s", max_bridge_s, "longest gap of the IMU that is bridged at all [s]");
  config.field("max_step_s", max_step_s, "longest integration step [s]");
  config.field("gap_correlation_s", gap_correlation_s,
               "time after which motion in a gap is unrelated to that before it [s]");
  config.field("gap_strength", gap_strength, "unseen motion in long gaps, relative to the seen");
  config.field("gap_gyro_floor", gap_gyro_floor, "angular rate to expect in any gap [rad/s]");
  config.field("gap_accel_floor", gap_accel_floor, "acceleration to expect in any gap [m/s^2]");
}

void PreintegrationOptions::validate() const {
  check_option(max_gap_s > 0.0, "preintegration.max_gap_s", max_gap_s, "> 0");
  check_option(max_bridge_s >= max_gap_s && max_bridge_s <= 60.0, "preintegration.max_bridge_s",
               max_bridge_s, ">= max_gap_s and <= 60");
  check_option(max_step_s >= 1e-4 && max_step_s <= 1.0, "preintegration.max_step_s", max_step_s,
               "between 0.0001 and 1");
  check_option(gap_correlation_s > 0.0, "preintegration.gap_correlation_s", gap_correlation_s,
               "> 0");
  check_option(gap_strength > 0.0, "preintegration.gap_strength", gap_strength, "> 0");
  check_option(gap_gyro_floor >= 0.0, "preintegration.gap_gyro_floor", gap_gyro_floor, ">= 0");
  check_option(gap_accel_floor >= 0.0, "preintegration.gap_accel_floor", gap_accel_floor, ">= 0");
}

ImuMotion preintegrate(ImuRange samples,
                       std::int64_t time0_ns,
                       std::int64_t time1_ns,
                       const ImuBias& bias,
                       const ImuNoise& noise,
                       double time_offset_s,
                       const PreintegrationOptions& options,
                       PreintegrationRecord* record) {
  expects(time0_ns < time1_ns, "preintegrate: time0_ns must be before time1_ns");
  expects(std::abs(time_offset_s) <= kLargestOffset_s, "preintegrate: time_offset_s too large");
  ImuMotion frame;
  frame.time0_ns = time0_ns;
  frame.time1_ns = time1_ns;
  frame.dt_s = to_seconds(time1_ns - time0_ns);
  frame.bias = bias;
  frame.time_offset_s = time_offset_s;
  frame.covariance *= kUnknownVariance;
  frame.degraded = true;
  if (record == nullptr) return IntervalWalk(samples, frame, noise, options, nullptr).run();
  record->samples = samples;
  record->steps.clear();
  record->sources.clear();
  const ImuMotion motion = IntervalWalk(samples, frame, noise, options, record).run();
  if (!motion.valid) {
    record->steps.clear();
    record->sources.clear();
  }
  return motion;
}

ImuMotion correct_for_bias(const ImuMotion& motion, const ImuBias& new_bias) {
  Eigen::Matrix<double, 6, 1> change;
  change << new_bias.gyro - motion.bias.gyro, new_bias.accel - motion.bias.accel;
  ImuMotion corrected = motion;
  corrected.bias = new_bias;
  corrected.dR = motion.dR * lie::SO3d::exp(motion.J_dR_bias * change);
  corrected.dv += motion.J_dv_bias * change;
  corrected.dp += motion.J_dp_bias * change;
  return corrected;
}

ImuMotion correct_for_time_offset(const ImuMotion& motion, double new_time_offset_s) {
  const Eigen::Matrix<double, 9, 1> change =
      motion.J_time_offset * (new_time_offset_s - motion.time_offset_s);
  ImuMotion corrected = motion;
  corrected.time_offset_s = new_time_offset_s;
  corrected.dR = motion.dR * lie::SO3d::exp(change.head<3>());
  corrected.dv += change.segment<3>(3);
  corrected.dp += change.tail<3>();
  return corrected;
}

lie::NavState predict(const lie::NavState& state0,
                      const ImuMotion& motion,
                      const Eigen::Vector3d& gravity_world) {
  const double dt = motion.dt_s;
  const lie::SO3d& R0 = state0.T_world_body.rotation();
  const Eigen::Vector3d p1 = state0.T_world_body.translation() + dt * state0.v_world +
                             0.5 * dt * dt * gravity_world + R0 * motion.dp;
  return {lie::SE3d(R0 * motion.dR, p1), state0.v_world + dt * gravity_world + R0 * motion.dv};
}

ImuMotion motion_between(const lie::NavState& state0,
                         const lie::NavState& state1,
                         double dt_s,
                         const Eigen::Vector3d& gravity_world) {
  const lie::SO3d R0_inverse = state0.T_world_body.rotation().inverse();
  ImuMotion motion;
  motion.dt_s = dt_s;
  motion.dR = R0_inverse * state1.T_world_body.rotation();
  motion.dv = R0_inverse * (state1.v_world - state0.v_world - dt_s * gravity_world);
  motion.dp = R0_inverse * (state1.T_world_body.translation() - state0.T_world_body.translation() -
                            dt_s * state0.v_world - 0.5 * dt_s * dt_s * gravity_world);
  return motion;
}

Eigen::Matrix<double, 9, 1> difference(const ImuMotion& motion, const ImuMotion& reference) {
  Eigen::Matrix<double, 9, 1> result;
  result << (reference.dR.inverse() * motion.dR).log(), motion.dv - reference.dv,
      motion.dp - reference.dp;
  return result;
}

}  // namespace imslam::imu

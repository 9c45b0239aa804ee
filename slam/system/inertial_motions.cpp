#include "slam/system/inertial_motions.hpp"

#include "slam/base/parallel.hpp"

namespace imslam::system {
namespace {

constexpr double kSlopeReach_s = 0.025;

}  // namespace

ImuMotion integrate_interval(const Measurements& measurements,
                             std::int64_t time0_ns,
                             std::int64_t time1_ns,
                             const ImuBias& bias,
                             double time_offset_s,
                             const imu::PreintegrationOptions& options) {
  const auto integrate = [&](double offset_s) {
    return imu::preintegrate(measurements.readings(), time0_ns, time1_ns, bias,
                             measurements.imu_noise, offset_s, options);
  };
  ImuMotion motion = integrate(time_offset_s);
  const auto seen = [](const ImuMotion& of) { return of.valid && !of.degraded; };
  if (!seen(motion)) return motion;
  const ImuMotion earlier = integrate(time_offset_s - kSlopeReach_s);
  const ImuMotion later = integrate(time_offset_s + kSlopeReach_s);
  // While streaming, what comes after the newest frame is not known yet.
  const double ahead_s = seen(later) ? kSlopeReach_s : 0.0;
  const double behind_s = seen(earlier) ? kSlopeReach_s : 0.0;
  if (ahead_s + behind_s == 0.0) return motion;
  motion.J_time_offset.setZero();
  if (ahead_s > 0.0) motion.J_time_offset += imu::difference(later, motion);
  if (behind_s > 0.0) motion.J_time_offset -= imu::difference(earlier, motion);
  motion.J_time_offset /= ahead_s + behind_s;
  return motion;
}

std::vector<ImuMotion> integrate_intervals(const Measurements& measurements,
                                           const BiasOfFrame& bias,
                                           double time_offset_s,
                                           const imu::PreintegrationOptions& options) {
  const auto& times_ns = measurements.times_ns;
  if (times_ns.size() < 2) return {};
  std::vector<ImuMotion> motions(times_ns.size() - 1);
  parallel_for(motions.size(), [&](std::size_t i) {
    motions[i] = integrate_interval(measurements, times_ns[i], times_ns[i + 1], bias(i),
                                    time_offset_s, options);
  });
  return motions;
}

}  // namespace imslam::system

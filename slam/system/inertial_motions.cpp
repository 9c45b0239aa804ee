#include "slam/system/inertial_motions.hpp"

#include "slam/base/parallel.hpp"

namespace imslam::system {

std::vector<ImuMotion> integrate_intervals(const Measurements& measurements,
                                           const BiasOfFrame& bias,
                                           double time_offset_s,
                                           const imu::PreintegrationOptions& options) {
  const auto& times_ns = measurements.times_ns;
  if (times_ns.size() < 2) return {};
  const imu::ImuRange readings = measurements.readings();
  std::vector<ImuMotion> motions(times_ns.size() - 1);
  parallel_for(motions.size(), [&](std::size_t i) {
    motions[i] = imu::preintegrate(readings, times_ns[i], times_ns[i + 1], bias(i),
                                   measurements.imu_noise, time_offset_s, options);
  });
  return motions;
}

}  // namespace imslam::system

#include "slam/system/inertial_start.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "imu_net/gravity_alignment.hpp"
#include "imu_net/gyro_alignment.hpp"
#include "pgo/initialization.hpp"
#include "slam/base/time.hpp"
#include "slam/system/inertial_motions.hpp"

namespace imslam::system {
namespace {

/// Long enough for gravity to stand out, short enough for odometry not to have drifted.
constexpr std::size_t kStretch = 200;  // [frames]
/// Where a part of every long stretch is bad, a shorter one has to do.
constexpr std::size_t kShortestStretch = 50;  // [frames]

/// What vision says about each interval; a motion over several intervals is shared out evenly.
std::vector<RelativeMotion> interval_motions(const Measurements& measurements,
                                             const OdometryChain& chain) {
  const auto& times_ns = measurements.times_ns;
  std::vector<RelativeMotion> motions(times_ns.size() - 1);
  auto source = measurements.odometry.begin();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    while (source != measurements.odometry.end() && source->time1_ns < times_ns[i + 1]) ++source;
    if (!chain.covered[i + 1] || source == measurements.odometry.end()) continue;
    motions[i] = *source;
    motions[i].time0_ns = times_ns[i];
    motions[i].time1_ns = times_ns[i + 1];
    motions[i].T_body0_body1 = chain.trajectory.poses[i].inverse() * chain.trajectory.poses[i + 1];
  }
  return motions;
}

template <typename Values>
Values slice(const Values& values, std::size_t first, std::size_t last) {
  using Offset = typename Values::difference_type;
  return Values(values.begin() + static_cast<Offset>(first),
                values.begin() + static_cast<Offset>(last));
}

/// All states from the odometry, laid onto what initialisation found at `anchor`.
std::vector<pgo::State> lay_chain(const OdometryChain& chain,
                                  std::size_t anchor,
                                  const pgo::Initialization& start) {
  const Trajectory& odometry = chain.trajectory;
  const lie::SE3d at_anchor =
      start.states.front().nav.T_world_body * odometry.poses[anchor].inverse();
  // The first frame of all, not that of the stretch, is to be at the origin, heading along x.
  const Eigen::Vector3d gravity_body0 =
      (at_anchor * odometry.poses.front()).rotation().inverse() * -Eigen::Vector3d::UnitZ();
  const lie::SE3d T_world_body0(pgo::level(gravity_body0), Eigen::Vector3d::Zero());
  const lie::SE3d T_world_chain = T_world_body0 * odometry.poses.front().inverse();

  std::vector<pgo::State> states(odometry.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0;
    const std::size_t after = std::min(i + 1, states.size() - 1);
    const Eigen::Vector3d displacement =
        odometry.poses[after].translation() - odometry.poses[before].translation();
    const double dt_s = to_seconds(odometry.times_ns[after] - odometry.times_ns[before]);
    states[i].time_ns = odometry.times_ns[i];
    states[i].nav.T_world_body = T_world_chain * odometry.poses[i];
    states[i].nav.v_world = T_world_chain.rotation() * Eigen::Vector3d(displacement / dt_s);
    states[i].bias = start.bias;
  }
  return states;
}

/// What the IMU itself says about the beginning: rest, or the belief of a correction.
ImuBias bias_without_vision(const Measurements& measurements,
                            const std::optional<imu::GravityAlignment>& rest) {
  ImuBias bias;
  if (rest) bias.gyro = rest->bias.gyro;
  for (const BiasBelief& belief : measurements.bias_beliefs) {
    (belief.axis < 3 ? bias.gyro : bias.accel)[belief.axis % 3] = belief.bias;
  }
  return bias;
}

std::vector<RelativeMotion> moved_in_time(std::vector<RelativeMotion> motions, double seconds) {
  for (RelativeMotion& motion : motions) {
    motion.time0_ns += to_nanoseconds(seconds);
    motion.time1_ns += to_nanoseconds(seconds);
  }
  return motions;
}

/// Upright on the accelerometer's word alone, at the first frame.
pgo::Initialization start_from_rest(const imu::GravityAlignment& rest, const ImuBias& bias) {
  pgo::Initialization start;
  start.states.resize(1);
  start.states.front().nav.T_world_body = lie::SE3d(rest.R_world_body, Eigen::Vector3d::Zero());
  start.bias = bias;
  start.success = true;
  return start;
}

}  // namespace

InertialStart start_inertial(const Measurements& measurements,
                             const OdometryChain& chain,
                             const SlamOptions& options) {
  InertialStart start;
  const auto rest = imu::align_to_gravity(measurements.readings(), measurements.times_ns.front(),
                                          measurements.imu_noise, options.still);
  ImuBias bias = bias_without_vision(measurements, rest);
  imu::GyroAlignmentOptions alignment_options = options.gyro_alignment;
  alignment_options.estimate_time_offset = options.pgo.estimate_time_offset;
  // Vision on the clock that the IMU is expected to have: the offset that is left is small.
  const double expected_s = options.system.time_offset_s;
  start.time_offset_s = expected_s;
  if (const auto alignment =
          imu::align_gyro(moved_in_time(measurements.odometry, expected_s), measurements.readings(),
                          measurements.imu_noise, alignment_options)) {
    bias.gyro = alignment->gyro_bias;
    start.time_offset_s = expected_s + alignment->time_offset_s;
    start.time_offset_sigma_s = std::sqrt(alignment->covariance(3, 3));
  }
  start.visual = interval_motions(measurements, chain);
  start.inertial = integrate_intervals(
      measurements, [&](std::size_t) { return bias; }, start.time_offset_s, options.preintegration);

  pgo::InitializationOptions initialization;
  initialization.gravity_magnitude = options.pgo.gravity_magnitude;
  for (std::size_t stretch = kStretch; stretch >= kShortestStretch; stretch /= 2) {
    for (std::size_t first = 0; first < start.inertial.size(); first += stretch) {
      const std::size_t last = std::min(first + stretch, start.inertial.size());
      const auto found = pgo::initialize(slice(start.visual, first, last),
                                         slice(start.inertial, first, last), initialization);
      if (found.success) {
        start.states = lay_chain(chain, first, found);
        return start;
      }
      if (start.reason.empty()) start.reason = found.reason;
    }
  }
  if (rest) start.states = lay_chain(chain, 0, start_from_rest(*rest, bias));
  return start;
}

}  // namespace imslam::system

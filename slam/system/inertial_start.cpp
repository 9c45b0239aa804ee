#include "slam/system/inertial_start.hpp"

#include <algorithm>

#include "pgo/initialization.hpp"
#include "slam/base/time.hpp"

namespace imslam::system {
namespace {

/// Long enough for gravity to stand out, short enough for odometry not to have drifted.
constexpr std::size_t kStretch = 200;  // [frames]

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

}  // namespace

InertialStart start_inertial(const Measurements& measurements,
                             const OdometryChain& chain,
                             const std::vector<ImuMotion>& motions,
                             double gravity_magnitude) {
  InertialStart result;
  const std::vector<RelativeMotion> visual = interval_motions(measurements, chain);
  pgo::InitializationOptions options;
  options.gravity_magnitude = gravity_magnitude;
  for (std::size_t first = 0; first < motions.size(); first += kStretch) {
    const std::size_t last = std::min(first + kStretch, motions.size());
    const auto start =
        pgo::initialize(slice(visual, first, last), slice(motions, first, last), options);
    if (start.success) {
      result.states = lay_chain(chain, first, start);
      return result;
    }
    if (result.reason.empty()) result.reason = start.reason;
  }
  return result;
}

}  // namespace imslam::system

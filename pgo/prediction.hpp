#pragma once

#include "pgo/graph_data.hpp"

namespace imslam::pgo {

/// The state at the end of an IMU motion that starts at `from`, corrected to its bias (first order)
/// and to the time offset. gravity: in world [m/s^2].
State predict(const State& from,
              const ImuMotion& motion,
              const Eigen::Vector3d& gravity,
              double time_offset_s = 0.0);

/// The state at the end of a visual motion; the velocity is the mean one of the interval.
State predict(const State& from, const RelativeMotion& motion);

/// States along a chain of visual motions, the first at `first`, velocities from the displacements.
/// A motion that is not valid is bridged with the velocity and turn rate of the one before it.
std::vector<State> chain_states(const State& first, const std::vector<RelativeMotion>& motions);

}  // namespace imslam::pgo

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pgo/graph_data.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/system/measurements.hpp"

namespace imslam::system {

/// First guesses of all states of a visual-inertial graph, or why there are none.
struct InertialStart {
  std::vector<pgo::State> states;  ///< empty: see `reason`
  std::string reason;
};

/// Visual-inertial initialisation over the first stretch of the sequence that allows it; the chain
/// of odometry, turned upright, gives the states of the other frames.
///
/// `motions[i]` leads from frame i to i + 1.
InertialStart start_inertial(const Measurements& measurements,
                             const OdometryChain& chain,
                             const std::vector<ImuMotion>& motions,
                             double gravity_magnitude);

}  // namespace imslam::system

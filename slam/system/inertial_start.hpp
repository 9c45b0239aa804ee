#pragma once

#include <string>
#include <vector>

#include "pgo/graph_data.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/system/measurements.hpp"
#include "slam/system/slam_options.hpp"

namespace imslam::system {

/// First guesses of all states of a visual-inertial graph, or why there are none.
struct InertialStart {
  std::vector<pgo::State> states;  ///< empty: see `reason`
  std::string reason;

  std::vector<RelativeMotion> visual;  ///< per interval; a motion over several is shared out
  std::vector<ImuMotion> inertial;     ///< per interval, at the gyro bias and time offset found
  double time_offset_s = 0.0;          ///< [s]
  double time_offset_sigma_s = 0.0;    ///< [s]
};

/// Gyro bias and clock from vision's rotations, then visual-inertial initialisation over the first
/// stretch of the sequence that allows it; where none does, upright as the accelerometer says if
/// the body rests at the first frame. The chain of odometry, turned upright, gives the states of
/// the other frames. Needs two frames at least.
InertialStart start_inertial(const Measurements& measurements,
                             const OdometryChain& chain,
                             const SlamOptions& options);

}  // namespace imslam::system

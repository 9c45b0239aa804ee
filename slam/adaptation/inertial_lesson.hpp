#pragma once

#include <functional>

#include "slam/adaptation/adaptation_options.hpp"
#include "slam/adaptation/graph_teacher.hpp"
#include "slam/base/random.hpp"
#include "slam/system/slam_options.hpp"

namespace imslam::adaptation {

/// What all inertial lessons of one solution have in common.
struct InertialClass {
  const imu::ImuNetwork<float>& network;
  const GraphTeacher& teacher;
  const training::InertialLog& log;  ///< GraphTeacher::inertial_log()
  const system::SlamOptions& slam;
  const AdaptationOptions& options;
  std::function<bool(std::size_t state)> counts;  ///< states that may teach
};

/// What the inertial log teaches, on a tape:
///
///   graph_weight / 9 U(edge covariances)      what the network adds to the noise of the graph's
///                                             edges (GraphTeacher::inertial)
///   + imu::correction_loss()                  open integration over 0.5 to 10 s of the corrected
///                                             readings against the graph's own trajectory
nn::Var inertial_lesson(nn::Tape<float>& tape, const InertialClass& of, Random random);

}  // namespace imslam::adaptation

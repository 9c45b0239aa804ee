#pragma once

#include "slam/adaptation/adaptation_options.hpp"
#include "slam/adaptation/graph_teacher.hpp"
#include "slam/adaptation/learned_networks.hpp"
#include "slam/adaptation/motion_tracer.hpp"
#include "slam/sensors/calibration.hpp"

namespace imslam::adaptation {

/// What all visual lessons have in common.
struct VisualClass {
  const LearnedNetworks& networks;
  const GraphTeacher& teacher;
  StereoCamera camera;
  const vo::VoOptions& vo;
  const AdaptationOptions& options;
};

/// What one motion teaches, on a tape:
///
///   graph_weight / 6 U(T, F Sigma F)         the graph's view of the motion that the matches give
///   + match_weight (l_flow + l_stereo0 + l_stereo1)     its view of the matches: vo::match_loss()
///                                                       with where the points must lie
///
/// The labels of the second part follow from the solution and count as constants.
/// `usable` false: the motion cannot teach (it is not in the graph, or has no derivative); 0 then.
nn::Var visual_lesson(nn::Tape<float>& tape,
                      const MotionTrace& trace,
                      const VisualClass& of,
                      bool& usable);

}  // namespace imslam::adaptation

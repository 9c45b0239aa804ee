#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slam/adaptation/graph_teacher.hpp"
#include "slam/adaptation/learned_networks.hpp"
#include "slam/adaptation/motion_tracer.hpp"
#include "slam/system/run_sequence.hpp"

namespace imslam::adaptation {

/// One run over the sequence with the networks as they are, and what it teaches.
struct Epoch {
  DeviceCalibration device;  ///< as the run assumed it
  StereoCamera camera;       ///< likewise
  system::RunOutcome outcome;
  std::vector<MotionTrace> traces;      ///< of the motions drawn for lessons, in that order
  std::optional<GraphTeacher> teacher;  ///< empty: the graph cannot teach, see `reason`
  std::string reason;
  training::InertialLog log;  ///< of the teacher, where there is an IMU
};

/// The kernel of a graph that teaches: a convex one, so that solves converge to rounding error with
/// outliers too, and one that weighs what fits with 1, since covariances learn with the weights of
/// the edges held. Runs use one that outliers pull at less; teaching gained nothing by it.
inline constexpr const char* kTeachingKernel = "huber";
inline constexpr double kTeachingKernelWidth = 4.0;

/// Which sequence and how it is run.
struct EpochRequest {
  datasets::Sequence& sequence;
  const system::SlamOptions& slam;
  const AdaptationOptions& options;
  system::RunRequest run;  ///< frames, and who is told how far it is
  std::string label = {};  ///< among several sequences; empty: its own name

  std::string name() const { return label.empty() ? sequence.name() : label; }
};

/// Runs the sequence on `device`; `number` decides which motions are traced: steps_per_epoch x
/// edges of those that are not held out, drawn without putting back (all, over and over, if there
/// are fewer). `matches` (may be null) takes the matcher's answers down if it is empty, else stands
/// in for the matcher. Throws what run_sequence() throws, and InputError(kInterrupted) if
/// keep_going said stop.
std::unique_ptr<Epoch> run_epoch(const EpochRequest& request,
                                 const LearnedNetworks& networks,
                                 const DeviceCalibration& device,
                                 int number,
                                 const std::shared_ptr<vo::MatchRecording>& matches = nullptr);

}  // namespace imslam::adaptation

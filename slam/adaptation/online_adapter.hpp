#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slam/adaptation/graph_teacher.hpp"
#include "slam/adaptation/learned_networks.hpp"
#include "slam/adaptation/motion_tracer.hpp"
#include "slam/nn/training/data_parallel.hpp"
#include "slam/nn/training/optimizer.hpp"
#include "slam/system/run_sequence.hpp"

namespace imslam::adaptation {

/// Networks that learn while the run goes on, from what is past:
///
///   every online_every frames: the sliding window is the solved graph; its motions teach the
///   networks of vision, the states that have left it the IMU network; one step of the optimiser;
///   the front end goes on with the result
///
///   OnlineAdapter adapter(slam, options, sequence);
///   adapter.attach(request);                // a RunRequest
///   run_sequence(sequence, slam, request);
class OnlineAdapter {
 public:
  /// Throws what LearnedNetworks throws. `sequence` must outlive the adapter; of its inertial
  /// readings only those before the newest frame are looked at.
  OnlineAdapter(const system::SlamOptions& slam,
                const AdaptationOptions& options,
                const datasets::Sequence& sequence);

  /// Makes a run use the networks, and tell what it sees.
  void attach(system::RunRequest& request);

  /// "adapted online: 12 steps, 1 skipped" (no lesson, or not finite)
  std::string summary() const;

 private:
  void see(const StereoFrame& frame, const vo::VoOutput& seen);
  void learn(const pgo::PoseVelocityGraph& window);
  void remember(const pgo::PoseVelocityGraph& window);
  training::InertialLog past(const GraphTeacher& teacher) const;
  nn::Var lesson(nn::Tape<float>& tape, const GraphTeacher& teacher, std::size_t slot);
  void renew();

  system::SlamOptions slam_;
  AdaptationOptions options_;
  const datasets::Sequence& sequence_;
  LearnedNetworks networks_;
  StereoCamera camera_;      ///< as the run assumes it
  system::Networks in_use_;  ///< shared with the run; changed between its frames
  MotionTracer tracer_;
  nn::DataParallel<float> batch_;
  nn::Adam<float> optimizer_;
  nn::Gradients<float> gradients_;
  std::vector<pgo::State> past_states_;  ///< smoothed: they have left the window
  training::InertialLog log_;            ///< of the present step
  std::vector<char> usable_;
  int windows_ = 0;
  int steps_ = 0;
  int skipped_ = 0;
};

}  // namespace imslam::adaptation

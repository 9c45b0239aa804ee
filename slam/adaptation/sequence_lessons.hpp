#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slam/adaptation/epoch.hpp"
#include "slam/adaptation/epoch_scores.hpp"
#include "slam/learner/training_record.hpp"
#include "slam/training/inertial_log_generator.hpp"
#include "vo_net/match_recording.hpp"

namespace imslam::adaptation {

/// One sequence that networks learn from: its runs, and what each of them teaches, lesson by
/// lesson. The networks are the training's; they live longer.
class SequenceLessons {
 public:
  /// `device`: index in networks.
  SequenceLessons(const EpochRequest& request, LearnedNetworks& networks, std::size_t device);

  /// Runs the sequence with the networks as they are. Networks that see no motion at all are the
  /// worst, and teach nothing, unless they `must_see`. Throws what run_epoch() throws.
  void run(int number, bool must_see);
  /// Whether run() needs no matcher: it was asked before, or learns.
  bool has_matches() const { return !matches_ || matches_->size() > 0; }
  const Epoch& epoch() const { return *epoch_; }
  EpochScores scores();

  /// Motions of vision, then a stretch of the inertial log, then rehearsals.
  std::size_t slots() const { return usable_.size(); }
  /// Before the lessons of a step, on the calling thread.
  void begin_step();
  /// Called from several threads at once, each with another slot. `step`: of the whole training.
  nn::Var lesson(nn::Tape<float>& tape, std::size_t slot, int step);
  /// Of the lessons since begin_step().
  learner::BatchTally tally() const;

  std::size_t device() const { return device_; }
  /// What the graph says of the device; as the run assumed it if it says nothing.
  DeviceCalibration refined_device() const;

 private:
  std::size_t inertial_slot() const { return static_cast<std::size_t>(request_.options.edges); }
  bool teaches(std::size_t slot) const;
  bool is_inertial(std::size_t slot) const { return slot >= inertial_slot(); }
  nn::Var inertial(nn::Tape<float>& tape, int step) const;
  nn::Var rehearse(nn::Tape<float>& tape, std::size_t slot, int step) const;
  nn::Var visual(nn::Tape<float>& tape, std::size_t slot, int step, bool& usable) const;

  EpochRequest request_;
  LearnedNetworks& networks_;
  std::size_t device_;
  std::shared_ptr<vo::MatchRecording> matches_;  ///< null: the matcher is asked in every run
  std::unique_ptr<Epoch> epoch_;
  std::optional<training::InertialLog> truth_;  ///< of the inertial sensor
  training::InertialLogGenerator simulated_;    ///< logs of other sensors
  std::vector<char> usable_;                    ///< by slot of the last step
};

}  // namespace imslam::adaptation

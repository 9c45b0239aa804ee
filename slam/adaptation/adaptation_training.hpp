#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/adaptation/epoch.hpp"
#include "slam/adaptation/epoch_scores.hpp"
#include "slam/learner/network_training.hpp"

namespace imslam::adaptation {

/// Imperative learning on one sequence:
///
///   epoch   run the front end with the networks as they are; solve the graph      (lower level)
///           steps_per_epoch times: some motions and a stretch of the inertial log, forward on
///           tapes, U at the graph's solution, back to the networks                (upper level)
///
/// The solution is that of the epoch's beginning: with one step per epoch the gradient is the exact
/// "one step" gradient of U; with more, solver and networks take turns on the same U. A graph that
/// has not converged teaches nothing: its steps are skipped and counted.
/// What is looked at after an epoch is the run that the next one learns from.
class AdaptationTraining : public learner::NetworkTraining {
 public:
  /// `data_sha256`: of the sequence; a checkpoint of another one is refused.
  AdaptationTraining(const EpochRequest& request, const std::string& data_sha256);

  learner::ValidationRecord look() override;
  std::string log_columns() const override { return EpochScores::columns(); }
  std::string name() const override { return "networks"; }
  nn::ModelCard card() const override;

  LearnedNetworks& networks() { return networks_; }

 private:
  nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) override;
  void prepare_step() override;
  learner::BatchTally tally() const override;
  void save_more(nn::WeightsWriter& writer) const override;
  void restore_more(const nn::WeightsFile& checkpoint) override;

  int steps_per_epoch() const { return request_.options.steps_per_epoch; }
  std::size_t inertial_slot() const { return static_cast<std::size_t>(request_.options.edges); }
  bool teaches(std::size_t slot) const;
  /// The run with the weights that the present epoch began with.
  const Epoch& epoch();
  void begin_epoch(int first_step);
  void refine_device();

  EpochRequest request_;
  std::string data_sha256_;
  LearnedNetworks networks_;
  std::unique_ptr<Epoch> epoch_;
  int epoch_step_ = -1;                           ///< step_count() when epoch_ was run
  std::vector<nn::Tensor<float>> epoch_weights_;  ///< all parameters then
  std::optional<training::InertialLog> truth_;    ///< of the inertial sensor
  std::vector<char> usable_;                      ///< by slot of the last batch
};

}  // namespace imslam::adaptation

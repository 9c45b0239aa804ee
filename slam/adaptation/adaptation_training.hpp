#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "slam/adaptation/sequence_lessons.hpp"
#include "slam/learner/network_training.hpp"

namespace imslam::adaptation {

/// Imperative learning on one sequence, or on several at once:
///
///   epoch   run the front end with the networks as they are; solve the graph      (lower level)
///           steps_per_epoch times: some motions and a stretch of the inertial log of each
///           sequence, forward on tapes, U at the graph's solution, back to the networks (upper)
///
/// The solution is that of the epoch's beginning: with one step per epoch the gradient is the exact
/// "one step" gradient of U; with more, solver and networks take turns on the same U. A graph that
/// has not converged teaches nothing: its steps are skipped and counted.
/// What is looked at after an epoch is the run that the next one learns from.
///
/// A matching network that does not learn is asked in the first epoch only (recall_matches).
///
/// Sequence s belongs to rank s % size of the group: only there is it run. Weights, device
/// calibrations and looks are the same on all ranks, for any number of them.
class AdaptationTraining : public learner::NetworkTraining {
 public:
  /// `requests`: one per sequence, with equal options; `data_sha256`: of all of them, a checkpoint
  /// of others is refused. Throws InputError(kUsage) if options do not go with several processes.
  AdaptationTraining(const std::vector<EpochRequest>& requests,
                     const std::string& data_sha256,
                     ProcessGroup& group);

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

  const AdaptationOptions& options() const { return requests_.front().options; }
  int steps_per_epoch() const { return options().steps_per_epoch; }
  /// Makes sure that the runs are those with the weights that the present epoch began with.
  void have_runs();
  void begin_epoch(int first_step);
  void run_sequences(int first_step);
  void recall_first_matches();
  void refine_devices();
  /// Calls `act` while all parameters have other values.
  void with_weights(std::vector<nn::Tensor<float>>& weights, const std::function<void()>& act);
  std::vector<nn::Tensor<float>> present_weights() const;

  std::vector<EpochRequest> requests_;
  std::string data_sha256_;
  ProcessGroup& group_;
  std::vector<std::size_t> devices_;  ///< by sequence
  LearnedNetworks networks_;
  std::vector<std::unique_ptr<SequenceLessons>> lessons_;  ///< by sequence; null: another rank's
  std::vector<nn::Tensor<float>> given_weights_;           ///< all parameters as given
  int epoch_step_ = -1;                           ///< step_count() when the sequences were run
  std::vector<nn::Tensor<float>> epoch_weights_;  ///< all parameters then
};

}  // namespace imslam::adaptation

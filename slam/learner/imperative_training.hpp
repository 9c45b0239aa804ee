#pragma once

#include <vector>

#include "slam/learner/network_training.hpp"

namespace imslam::learner {

/// A training whose samples learn through solvers. A derived class holds one task and one strategy
/// per slot of the batch and writes
///
///   nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) override {
///     const nn::Var z = network_.forward(tape, tape.constant(input(slot)));
///     return through_solver(tape, z, *strategies_[slot], stream(slot), slot);
///   }
///
/// Samples whose solve gave no gradient are left out of the batch's mean and counted by reason.
class ImperativeTraining : public NetworkTraining {
 protected:
  using NetworkTraining::NetworkTraining;

  /// The upper cost of what the network says, on the tape. Once per slot and step.
  nn::Var through_solver(nn::Tape<float>& tape,
                         nn::Var z,
                         GradientStrategy& strategy,
                         const Random& random,
                         std::size_t slot);

  /// The gradients of the last batch, slot by slot.
  const std::vector<UpperGradient>& outcomes() const { return outcomes_; }

 private:
  BatchTally tally() const override;

  std::vector<UpperGradient> outcomes_ =
      std::vector<UpperGradient>(static_cast<std::size_t>(common_options().batch));
};

}  // namespace imslam::learner

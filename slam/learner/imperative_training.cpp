#include "slam/learner/imperative_training.hpp"

#include <algorithm>

#include "slam/learner/imperative_loss.hpp"

namespace imslam::learner {

nn::Var ImperativeTraining::through_solver(nn::Tape<float>& tape,
                                           nn::Var z,
                                           GradientStrategy& strategy,
                                           const Random& random,
                                           std::size_t slot) {
  outcomes_.at(slot) = strategy(numbers_of(tape, z), random);
  return imperative_loss(tape, z, outcomes_[slot]);
}

BatchTally ImperativeTraining::tally() const {
  BatchTally tally;
  for (const UpperGradient& outcome : outcomes_) {
    if (!outcome.usable()) ++tally.refused[static_cast<std::size_t>(outcome.refusal)];
    if (outcome.usable()) tally.residual = std::max(tally.residual, outcome.residual);
  }
  return tally;
}

}  // namespace imslam::learner

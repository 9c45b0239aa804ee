#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "slam/learner/gradient_strategy.hpp"

namespace imslam::learner {

/// What came of a batch: which samples gave no gradient, and why.
struct BatchTally {
  std::array<std::int64_t, kRefusalCount> refused{};  ///< by Refusal
  double residual = 0.0;                              ///< largest one of the lower solves

  std::int64_t refused_samples() const;
};

/// The last step of a training, for people and logs.
struct StepRecord {
  double loss = 0.0;           ///< mean over the samples that gave a gradient
  double gradient_norm = 0.0;  ///< before clipping
  double rate = 0.0;           ///< of the optimiser
  double residual = 0.0;       ///< largest dL/dphi of the lower solves; 0 without lower level
};

/// What was left out since the start of a training. A step without a gradient changes nothing.
struct SkipCounts {
  int not_finite = 0;                                 ///< steps: loss or gradient not finite
  int unsolved = 0;                                   ///< steps: every sample was refused
  std::array<std::int64_t, kRefusalCount> samples{};  ///< refused, by Refusal

  int steps() const { return not_finite + unsolved; }
  std::string text() const;  ///< "2 steps not finite, 7 samples unconverged solve"; or empty
};

}  // namespace imslam::learner

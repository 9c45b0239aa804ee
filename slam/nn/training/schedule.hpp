#pragma once

#include <cstdint>

namespace imslam::nn {

// Learning rates as functions of the step, counted from 0; the last value holds beyond the end.

/// peak drop^(step / every), whole steps down.
struct StepSchedule {
  double peak = 1e-3;
  std::int64_t every = 1000;
  double drop = 0.1;
  double rate(std::int64_t step) const;
};

/// Linear from 0 to peak during the warm-up, then half a cosine down to `end`.
struct CosineSchedule {
  double peak = 1e-3;
  std::int64_t steps = 1000;  ///< in all
  std::int64_t warm_up = 0;   ///< of them
  double end = 0.0;
  double rate(std::int64_t step) const;
};

/// Half a cosine up from peak / start_divisor during `rise` of the steps, then half a cosine down
/// to peak / end_divisor. Smith, Topin 2018.
struct OneCycleSchedule {
  double peak = 1e-3;
  std::int64_t steps = 1000;
  double rise = 0.3;
  double start_divisor = 25.0;
  double end_divisor = 1e4;
  double rate(std::int64_t step) const;
};

/// Falls by `factor` when a watched loss has not become better for `patience` looks in a row.
class PlateauSchedule {
 public:
  struct Options {
    double start = 1e-3;
    double factor = 0.1;
    int patience = 4;
    double smallest = 1e-7;
    double threshold = 1e-4;  ///< relative: better means < (1 - threshold) best
  };
  /// All that it remembers, for checkpoints.
  struct State {
    double rate = 0.0;
    double best = 0.0;
    int bad_looks = 0;
    bool seen_any = false;
  };

  PlateauSchedule() : PlateauSchedule(Options()) {}
  explicit PlateauSchedule(const Options& options);

  /// A look at the loss; returns the rate from now on. A loss that is no number counts as worse.
  double observe(double loss);
  double rate() const { return state_.rate; }

  const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }

 private:
  Options options_;
  State state_;
};

}  // namespace imslam::nn

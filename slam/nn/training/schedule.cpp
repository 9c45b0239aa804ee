#include "slam/nn/training/schedule.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::nn {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// From `from` (share 0) to `to` (share 1) along half a cosine.
double half_cosine(double from, double to, double share) {
  return to + (from - to) * 0.5 * (1.0 + std::cos(kPi * std::clamp(share, 0.0, 1.0)));
}

double share_of(std::int64_t part, std::int64_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<std::int64_t>(whole, 1));
}

}  // namespace

double StepSchedule::rate(std::int64_t step) const {
  expects(every >= 1, "StepSchedule: every must be at least 1");
  return peak * std::pow(drop, static_cast<double>(step / every));
}

double CosineSchedule::rate(std::int64_t step) const {
  expects(warm_up >= 0 && warm_up <= steps, "CosineSchedule: warm_up within steps");
  if (step < warm_up) return peak * share_of(step + 1, warm_up);
  return half_cosine(peak, end, share_of(step - warm_up, steps - warm_up));
}

double OneCycleSchedule::rate(std::int64_t step) const {
  expects(rise > 0.0 && rise < 1.0, "OneCycleSchedule: rise in (0, 1)");
  const double share = share_of(step, steps);
  if (share < rise) return half_cosine(peak / start_divisor, peak, share / rise);
  return half_cosine(peak, peak / end_divisor, (share - rise) / (1.0 - rise));
}

PlateauSchedule::PlateauSchedule(const Options& options) : options_(options) {
  expects(options.factor > 0.0 && options.factor < 1.0 && options.patience >= 0,
          "PlateauSchedule: factor in (0, 1), patience >= 0");
  state_.rate = options.start;
}

double PlateauSchedule::observe(double loss) {
  const double bound = state_.best - options_.threshold * std::abs(state_.best);
  if (std::isfinite(loss) && (!state_.seen_any || loss < bound)) {
    state_.best = loss;
    state_.seen_any = true;
    state_.bad_looks = 0;
  } else if (++state_.bad_looks > options_.patience) {
    state_.rate = std::max(state_.rate * options_.factor, options_.smallest);
    state_.bad_looks = 0;
  }
  return state_.rate;
}

}  // namespace imslam::nn

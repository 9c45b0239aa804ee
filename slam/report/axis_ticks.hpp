#pragma once

#include <string>

namespace imslam::report {

/// The step between ticks: 1, 2 or 5 times a power of ten, at least `minimum` (> 0).
double round_tick(double minimum);

/// `value`, a multiple of `step`, with the decimals that the step needs.
std::string tick_text(double value, double step);

}  // namespace imslam::report

#include "slam/plugins/routing/stop_rule.hpp"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::routing {
namespace {

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

std::function<double()> clock_from_now(TimeOf time) {
  if (time == TimeOf::kProcessor) {
    return [start = processor_seconds(), threads = static_cast<double>(thread_count())] {
      return (processor_seconds() - start) / threads;
    };
  }
  return [start = std::chrono::steady_clock::now()] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
}

StopRule StopRule::after_iterations(std::int64_t iterations) {
  return StopRule(0.0, iterations, nullptr);
}

StopRule StopRule::of(double seconds, std::int64_t iterations, TimeOf time) {
  return StopRule(seconds, iterations, clock_from_now(time));
}

StopRule::StopRule(double seconds, std::int64_t iterations, Clock clock)
    : seconds_(clock ? seconds : 0.0), iterations_(iterations), clock_(std::move(clock)) {
  expects(seconds_ > 0.0 || iterations_ > 0, "StopRule: a search needs an end");
}

double StopRule::progress(std::int64_t iterations) const {
  double progress = 0.0;
  if (iterations_ > 0) {
    progress = static_cast<double>(iterations) / static_cast<double>(iterations_);
  }
  if (seconds_ > 0.0) progress = std::max(progress, clock_() / seconds_);
  return progress;
}

StopRule StopRule::part(double share) const {
  const auto iterations =
      static_cast<std::int64_t>(std::ceil(share * static_cast<double>(iterations_)));
  return StopRule(share * seconds_, iterations, clock_);
}

}  // namespace imslam::routing

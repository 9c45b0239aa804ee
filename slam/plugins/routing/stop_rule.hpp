#pragma once

#include <cstdint>
#include <functional>

namespace imslam::routing {

/// Whose seconds a search is given.
enum class TimeOf {
  kWall,       ///< those of the world
  kProcessor,  ///< those that the process had, shared out over its threads: for benchmarks on
               ///< machines that others use as well
};

/// Seconds since the call.
std::function<double()> clock_from_now(TimeOf time);

/// When a search ends: after a number of iterations, or when a clock says so.
///
/// A search that the clock ends is not the same twice; one that its iterations end is, bit by bit.
class StopRule {
 public:
  using Clock = std::function<double()>;  ///< seconds since the start

  static StopRule after_iterations(std::int64_t iterations);
  /// From now on by a clock of the computer; whatever is first; 0: no such limit.
  static StopRule of(double seconds, std::int64_t iterations, TimeOf time = TimeOf::kWall);
  /// The same by another clock.
  StopRule(double seconds, std::int64_t iterations, Clock clock);

  bool has_clock() const { return seconds_ > 0.0; }
  bool has_iterations() const { return iterations_ > 0; }
  std::int64_t iterations() const { return iterations_; }

  /// How far a search has come: 0 at the start, 1 or more at the end.
  double progress(std::int64_t iterations) const;

  /// The part up to `share` of it; e.g. 0.9 to leave time for a polish.
  StopRule part(double share) const;

 private:
  double seconds_;
  std::int64_t iterations_;
  Clock clock_;
};

}  // namespace imslam::routing

#pragma once

#include <cstdint>
#include <functional>

namespace imslam::routing {

/// When a search ends: after a number of iterations, or when a clock says so.
///
/// A search that the clock ends is not the same twice; one that its iterations end is, bit by bit.
class StopRule {
 public:
  using Clock = std::function<double()>;  ///< seconds since the start

  /// No time limit.
  static StopRule after_iterations(std::int64_t iterations);
  /// From now on, by the steady clock of the computer.
  static StopRule after_seconds(double seconds);
  /// Whatever is first; 0: no such limit. Without a clock there is no time limit.
  StopRule(double seconds, std::int64_t iterations, Clock clock);

  /// How far a search has come: 0 at the start, 1 or more at the end.
  double progress(std::int64_t iterations) const;

  /// The part up to `share` of it; e.g. 0.9 to leave time for a polish.
  StopRule part(double share) const;

  bool timed() const { return seconds_ > 0.0; }
  double seconds_left() const;  ///< 1e300 without a time limit

 private:
  double seconds_;
  std::int64_t iterations_;
  Clock clock_;
};

}  // namespace imslam::routing

#pragma once

#include <functional>
#include <vector>

namespace imslam::bench {

/// [s] Of one thread its own processor time, so that time lent to other programs does not count; of
/// several threads wall time.
double benchmark_clock_s(int threads);

/// How long repeats of one call took. Other work on the machine makes single times long, never
/// short: the smallest says most.
class TakenTimes {
 public:
  explicit TakenTimes(int threads) : threads_(threads) {}

  void measure(const std::function<void()>& call);
  void add(const std::vector<double>& seconds);

  bool empty() const { return seconds_.empty(); }
  double minimum_s() const;
  double median_s() const;

 private:
  int threads_;
  std::vector<double> seconds_;
};

/// A call not counted, then `calls` that are. OpenMP's threads go on spinning after a call: whoever
/// comes next waits until they have given up.
void measure_round(const std::function<void()>& call, int calls, TakenTimes& times);
void let_threads_sleep();

}  // namespace imslam::bench

#include "tools/bench/taken_times.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <thread>

namespace imslam::bench {

double benchmark_clock_s(int threads) {
  timespec time{};
  clock_gettime(threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void TakenTimes::measure(const std::function<void()>& call) {
  const double start = benchmark_clock_s(threads_);
  call();
  seconds_.push_back(benchmark_clock_s(threads_) - start);
}

void TakenTimes::add(const std::vector<double>& seconds) {
  seconds_.insert(seconds_.end(), seconds.begin(), seconds.end());
}

double TakenTimes::minimum_s() const { return *std::min_element(seconds_.begin(), seconds_.end()); }

double TakenTimes::median_s() const {
  std::vector<double> sorted = seconds_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[sorted.size() / 2];
}

void measure_round(const std::function<void()>& call, int calls, TakenTimes& times) {
  call();
  for (int i = 0; i < calls; ++i) times.measure(call);
  let_threads_sleep();
}

void let_threads_sleep() { std::this_thread::sleep_for(std::chrono::milliseconds(10)); }

}  // namespace imslam::bench

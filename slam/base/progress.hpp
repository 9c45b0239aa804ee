#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace imslam {

/// One line on a terminal: bar, count, rate, time left. Silent when stderr is not a terminal.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label, bool enabled = true);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `total` = 0: unknown, only count and rate are shown.
  void update(std::size_t done, std::size_t total, const std::string& note = "");

  /// Takes the line away, so that other output can follow.
  void clear();

  /// The line as it would be printed, without control characters. Pure, for tests.
  static std::string line(const std::string& label,
                          std::size_t done,
                          std::size_t total,
                          double elapsed_s,
                          const std::string& note,
                          std::size_t width);

 private:
  using Clock = std::chrono::steady_clock;

  std::string label_;
  bool enabled_;
  bool printed_ = false;
  Clock::time_point start_;
  Clock::time_point last_print_;
};

}  // namespace imslam

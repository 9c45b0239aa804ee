#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace imslam::system {

/// Durations of the stages of the pipeline, one value per frame and stage.
class StageTimer {
 public:
  struct Summary {
    double mean_ms = 0.0;
    double p50_ms = 0.0;
    double p99_ms = 0.0;
    double max_ms = 0.0;
    double total_s = 0.0;
    std::size_t count = 0;
  };

  void add(const std::string& stage, double duration_ms);

  /// Stages in alphabetical order.
  std::map<std::string, Summary> summaries() const;
  const std::vector<float>& values_ms(const std::string& stage) const;

 private:
  std::map<std::string, std::vector<float>> values_ms_;
};

/// Adds the time from its construction to its destruction.
class StageScope {
 public:
  StageScope(StageTimer& timer, std::string stage);
  ~StageScope();
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;

 private:
  StageTimer& timer_;
  std::string stage_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace imslam::system

#include "slam/system/stage_timer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace imslam::system {
namespace {

/// The value below which the fraction `q` of the sorted values lies (nearest rank).
double quantile(const std::vector<float>& sorted, double q) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return static_cast<double>(sorted[static_cast<std::size_t>(std::lround(q * last))]);
}

StageTimer::Summary summarise(std::vector<float> values) {
  StageTimer::Summary summary;
  if (values.empty()) return summary;
  std::sort(values.begin(), values.end());
  const double total = std::accumulate(values.begin(), values.end(), 0.0);
  summary.count = values.size();
  summary.mean_ms = total / static_cast<double>(values.size());
  summary.p50_ms = quantile(values, 0.5);
  summary.p99_ms = quantile(values, 0.99);
  summary.max_ms = static_cast<double>(values.back());
  summary.total_s = total / 1000.0;
  return summary;
}

}  // namespace

void StageTimer::add(const std::string& stage, double duration_ms) {
  values_ms_[stage].push_back(static_cast<float>(duration_ms));
}

std::map<std::string, StageTimer::Summary> StageTimer::summaries() const {
  std::map<std::string, Summary> result;
  for (const auto& [stage, values] : values_ms_) result[stage] = summarise(values);
  return result;
}

const std::vector<float>& StageTimer::values_ms(const std::string& stage) const {
  static const std::vector<float> none;
  const auto found = values_ms_.find(stage);
  return found == values_ms_.end() ? none : found->second;
}

StageScope::StageScope(StageTimer& timer, std::string stage)
    : timer_(timer), stage_(std::move(stage)), start_(std::chrono::steady_clock::now()) {}

StageScope::~StageScope() {
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start_;
  timer_.add(stage_, elapsed.count());
}

}  // namespace imslam::system

#include "tools/bench/matching/quality.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imslam::bench {
namespace {

Quality quality_of(const std::vector<double>& errors, std::size_t asked) {
  Quality quality;
  quality.points = errors.size();
  const auto count = static_cast<double>(errors.size());
  quality.coverage = asked == 0 ? 0.0 : count / static_cast<double>(asked);
  quality.median = median(errors);
  quality.mean = std::accumulate(errors.begin(), errors.end(), 0.0) / count;
  const auto gross =
      std::count_if(errors.begin(), errors.end(), [](double error) { return error > kGrossError; });
  quality.gross = static_cast<double>(gross) / count;
  return quality;
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Quality natural_quality(const std::vector<PointResult>& results) {
  std::vector<double> errors;
  for (const PointResult& result : results) {
    if (result.accepted) errors.push_back(result.error);
  }
  return quality_of(errors, results.size());
}

Quality quality_at(double coverage, const std::vector<PointResult>& results) {
  std::vector<const PointResult*> best;
  for (const PointResult& result : results) {
    if (result.answered) best.push_back(&result);
  }
  std::stable_sort(best.begin(), best.end(),
                   [](const PointResult* a, const PointResult* b) { return a->score > b->score; });
  const auto wanted =
      static_cast<std::size_t>(std::lround(coverage * static_cast<double>(results.size())));
  best.resize(std::min(best.size(), wanted));
  std::vector<double> errors;
  for (const PointResult* result : best) errors.push_back(result->error);
  return quality_of(errors, results.size());
}

}  // namespace imslam::bench

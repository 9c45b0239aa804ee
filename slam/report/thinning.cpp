#include "slam/report/thinning.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::report {
namespace {

bool replaces(double candidate, double kept, Extreme keep) {
  if (std::isnan(candidate)) return false;
  if (std::isnan(kept)) return true;
  if (keep == Extreme::kSmallest) return candidate < kept;
  if (keep == Extreme::kLargestMagnitude) return std::abs(candidate) > std::abs(kept);
  return false;
}

double quantile(const std::vector<double>& sorted, double fraction) {
  const double position = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double rest = position - static_cast<double>(below);
  return sorted[below] + rest * (sorted[above] - sorted[below]);
}

}  // namespace

std::vector<std::size_t> spread(std::size_t count, std::size_t limit) {
  expects(limit >= 2, "spread: limit must be at least 2");
  std::vector<std::size_t> indices;
  const std::size_t kept = std::min(count, limit);
  for (std::size_t i = 0; i < kept; ++i) {
    indices.push_back(kept < 2 ? i : i * (count - 1) / (kept - 1));
  }
  return indices;
}

std::vector<float> thin(const std::vector<double>& values, std::size_t limit, Extreme keep) {
  const std::size_t kept = std::min(values.size(), limit);
  std::vector<float> out;
  for (std::size_t bucket = 0; bucket < kept; ++bucket) {
    const std::size_t begin = bucket * values.size() / kept;
    const std::size_t end = (bucket + 1) * values.size() / kept;
    double best = values[begin];
    for (std::size_t i = begin + 1; i < end; ++i) {
      if (replaces(values[i], best, keep)) best = values[i];
    }
    out.push_back(static_cast<float>(best));
  }
  return out;
}

BoxSummary box_summary(std::vector<double> values) {
  expects(!values.empty(), "box_summary: no values");
  std::sort(values.begin(), values.end());
  BoxSummary box;
  box.count = values.size();
  box.q1 = quantile(values, 0.25);
  box.median = quantile(values, 0.5);
  box.q3 = quantile(values, 0.75);
  box.max = values.back();
  const double reach = 1.5 * (box.q3 - box.q1);
  // With few samples an interpolated quartile lies beyond the last sample that is in reach.
  const double first_in_reach = *std::lower_bound(values.begin(), values.end(), box.q1 - reach);
  const double last_in_reach =
      *(std::upper_bound(values.begin(), values.end(), box.q3 + reach) - 1);
  box.low = std::min(first_in_reach, box.q1);
  box.high = std::max(last_in_reach, box.q3);
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  box.rmse = std::sqrt(squares / static_cast<double>(box.count));
  return box;
}

}  // namespace imslam::report

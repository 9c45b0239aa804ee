#include "slam/evaluation/statistics.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::evaluation {
namespace {

/// Neumaier's compensated sum: the result does not degrade with the length of the list.
class Sum {
 public:
  void add(double value) {
    const double sum = sum_ + value;
    rest_ += std::abs(sum_) >= std::abs(value) ? (sum_ - sum) + value : (value - sum) + sum_;
    sum_ = sum;
  }
  double value() const { return sum_ + rest_; }

 private:
  double sum_ = 0.0;
  double rest_ = 0.0;
};

double median_of(std::vector<double> sorted) {
  std::sort(sorted.begin(), sorted.end());
  const std::size_t middle = sorted.size() / 2;
  if (sorted.size() % 2 == 1) return sorted[middle];
  return 0.5 * (sorted[middle - 1] + sorted[middle]);
}

}  // namespace

Statistics statistics(const std::vector<double>& errors) {
  expects(!errors.empty(), "statistics: at least one error");
  const auto count = static_cast<double>(errors.size());
  Sum sum;
  Sum squares;
  for (const double e : errors) {
    sum.add(e);
    squares.add(e * e);
  }
  Statistics s;
  s.mean = sum.value() / count;
  s.sse = squares.value();
  s.rmse = std::sqrt(s.sse / count);
  s.median = median_of(errors);
  Sum deviations;  // second pass: sse/n - mean^2 would cancel
  for (const double e : errors) deviations.add((e - s.mean) * (e - s.mean));
  s.std = std::sqrt(deviations.value() / count);
  const auto [lowest, highest] = std::minmax_element(errors.begin(), errors.end());
  s.min = *lowest;
  s.max = *highest;
  if (!std::isfinite(s.sse) || !std::isfinite(s.std) || !std::isfinite(s.max)) {
    throw InputError("the errors are beyond what can be squared; are the positions in metres?",
                     ExitCode::kEvaluation);
  }
  return s;
}

}  // namespace imslam::evaluation

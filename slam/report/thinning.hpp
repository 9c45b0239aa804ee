#pragma once

#include <cstddef>
#include <vector>

namespace imslam::report {

/// At most `limit` indices of [0, count), evenly spread, first and last included.
std::vector<std::size_t> spread(std::size_t count, std::size_t limit);

/// Which value of a bucket survives.
enum class Extreme { kFirst, kSmallest, kLargestMagnitude };

/// At most `limit` values, one for each of equal buckets of neighbours; NaN only where a whole
/// bucket is NaN. Peaks stay visible, which plain sub-sampling would lose.
std::vector<float> thin(const std::vector<double>& values, std::size_t limit, Extreme keep);

/// Tukey's box plot; quartiles by linear interpolation, whiskers at the last sample within 1.5
/// times the box.
struct BoxSummary {
  double low = 0.0;
  double q1 = 0.0;
  double median = 0.0;
  double q3 = 0.0;
  double high = 0.0;
  double max = 0.0;
  double rmse = 0.0;
  std::size_t count = 0;
};

/// `values` are finite and not empty.
BoxSummary box_summary(std::vector<double> values);

}  // namespace imslam::report

#pragma once

#include <vector>

namespace imslam::evaluation {

/// evo's seven figures of a list of errors e, in the unit of e (sse: squared).
///
///   rmse = sqrt(mean e^2),  std = sqrt(mean (e - mean)^2)  (population),  sse = sum e^2
struct Statistics {
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< mean of the two middle values where their number is even
  double std = 0.0;
  double min = 0.0;
  double max = 0.0;
  double sse = 0.0;
};

/// `errors` must not be empty.
Statistics statistics(const std::vector<double>& errors);

}  // namespace imslam::evaluation

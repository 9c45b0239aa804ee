#pragma once

#include <vector>

namespace imslam::bench {

/// How one query point fared.
struct PointResult {
  bool answered = false;  ///< the method gave a displacement at all
  bool accepted = false;  ///< and stands by it
  double score = 0.0;     ///< the greater, the surer; comparable within one method only
  double error = 0.0;     ///< [px] length of the end point error

  // What a network said of itself, else NaN.
  double normalised_error = 0.0;  ///< Mahalanobis, by the predicted scale
  double confidence = 0.0;        ///< that the error is below kConfidentError
};

inline constexpr double kGrossError = 3.0;  ///< [px]

struct Quality {
  std::size_t points = 0;  ///< that count
  double coverage = 0.0;   ///< their share of the query points
  double median = 0.0;     ///< [px] NaN without points, as are the next two
  double mean = 0.0;       ///< [px]
  double gross = 0.0;      ///< share of errors above kGrossError
};

/// Over the points that the method accepts.
Quality natural_quality(const std::vector<PointResult>& results);

/// Over the best scored points, as many as make up `coverage`; all answered ones if there are
/// fewer.
Quality quality_at(double coverage, const std::vector<PointResult>& results);

/// The middle value (the upper one of two); NaN if there is none.
double median(std::vector<double> values);

}  // namespace imslam::bench

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/bench/matching/experiment.hpp"

namespace imslam::bench {

inline constexpr double kConfidentError = 2.0;  ///< [px] what a stated confidence speaks of

/// Does a network know how wrong it is? Over all query points, which are visible ones, but the
/// normalised error over those that it stands by.
///
/// Ideal: normalised_median 1.33 for flow (2-D t distribution with 3 degrees of freedom), 0.77 for
/// disparity (1-D); stated = right.
struct Calibration {
  double normalised_median = 0.0;
  double stated = 0.0;  ///< mean confidence
  double right = 0.0;   ///< share of errors below kConfidentError
};

/// A measurement in numbers.
struct Summary {
  std::string data;
  vo::MatchKind kind = vo::MatchKind::kFlow;
  Trial trial;
  std::string method;
  std::size_t queries = 0;
  Quality natural;
  std::size_t klt_points = 0;    ///< that KLT stands by, if it took part
  std::optional<Quality> equal;  ///< at its coverage
  std::optional<Calibration> calibration;
};

/// empty if nothing states an uncertainty
std::optional<Calibration> calibration_of(const std::vector<PointResult>& results);

std::vector<Summary> summarised(const std::string& data,
                                const std::vector<Measurement>& measurements);

}  // namespace imslam::bench

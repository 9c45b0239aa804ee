#include "tools/bench/matching/summary.hpp"

#include <algorithm>
#include <cmath>

namespace imslam::bench {
namespace {

/// The measurement of KLT on the same data; null if there is none.
const Measurement* klt_beside(const Measurement& measurement,
                              const std::vector<Measurement>& measurements) {
  const auto klt =
      std::find_if(measurements.begin(), measurements.end(), [&](const Measurement& other) {
        return other.method == kKltName && other.kind == measurement.kind &&
               other.trial.severity == measurement.trial.severity &&
               std::string(other.trial.condition.name) == measurement.trial.condition.name;
      });
  return klt == measurements.end() ? nullptr : &*klt;
}

}  // namespace

std::optional<Calibration> calibration_of(const std::vector<PointResult>& results) {
  std::vector<double> normalised;
  double confidence = 0.0;
  double right = 0.0;
  double stating = 0.0;
  for (const PointResult& result : results) {
    if (!std::isfinite(result.confidence)) continue;
    stating += 1.0;
    confidence += result.confidence;
    if (result.error < kConfidentError) right += 1.0;
    if (result.accepted) normalised.push_back(result.normalised_error);
  }
  if (stating == 0.0) return std::nullopt;
  return Calibration{median(normalised), confidence / stating, right / stating};
}

std::vector<Summary> summarised(const std::string& data,
                                const std::vector<Measurement>& measurements) {
  std::vector<Summary> summaries;
  for (const Measurement& m : measurements) {
    Summary summary;
    summary.data = data;
    summary.kind = m.kind;
    summary.trial = m.trial;
    summary.method = m.method;
    summary.queries = m.results.size();
    summary.natural = natural_quality(m.results);
    if (const Measurement* klt = klt_beside(m, measurements)) {
      const Quality quality = natural_quality(klt->results);
      summary.klt_points = quality.points;
      summary.equal = quality_at(quality.coverage, m.results);
    }
    summary.calibration = calibration_of(m.results);
    summaries.push_back(summary);
  }
  return summaries;
}

}  // namespace imslam::bench

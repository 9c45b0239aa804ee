#pragma once

#include <string>

#include "slam/evaluation/align.hpp"
#include "slam/evaluation/associate.hpp"
#include "slam/evaluation/errors.hpp"
#include "slam/evaluation/evaluate.hpp"
#include "slam/evaluation/evo_archive.hpp"
#include "slam/evaluation/statistics.hpp"

namespace imslam::evaluation {

/// A coordinate plane that both paths are laid into before errors are taken: the third coordinate
/// becomes 0, of the rotation only the turn about the normal remains (Euler angles, fixed x y z).
enum class Plane { kNone, kXy, kXz, kYz };

PosePath projected(const PosePath& path, Plane plane);

/// One figure in evo's order: align, project, measure.
struct MetricOptions {
  bool relative = false;  ///< RPE, else APE
  AlignmentOptions alignment;
  Relation relation = Relation::kTranslationPart;
  DeltaOptions delta;  ///< RPE only
  Plane projection = Plane::kNone;
};

struct MetricResult {
  std::string title;  ///< evo's
  ErrorSeries series;
  Statistics stats;
  PosePath reference;  ///< as measured: projected, if so asked
  AlignedPath aligned;
};

/// Checks both paths, carries the estimate to the reference's frame and pairs them in time; the
/// doubts about frames stand in the warnings.
MatchedPaths prepare(const PosePath& reference,
                     const PosePath& estimate,
                     const EvaluationOptions& options);

/// Throws InputError(kEvaluation), with evo's words, where evo refuses.
MetricResult measure(const MatchedPaths& matched, const MetricOptions& options);

/// What `evo_ape --save_results` would write.
EvoResult evo_result(const MatchedPaths& matched,
                     const MetricOptions& options,
                     const MetricResult& result);

}  // namespace imslam::evaluation

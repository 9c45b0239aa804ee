#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "slam/sensors/trajectory.hpp"

namespace imslam::evaluation {

/// Which number is taken of an error motion E (4x4).
enum class Relation {
  kTranslationPart,          ///< |t(E)|  [m]
  kRotationPart,             ///< |R(E) - I|_F
  kFullTransformation,       ///< |E - I|_F
  kRotationAngleDeg,         ///< |log R(E)|  [deg]
  kRotationAngleRad,         ///< |log R(E)|  [rad]
  kPointDistance,            ///< difference of the distances between two positions [m]
  kPointDistanceErrorRatio,  ///< that, relative to the reference's distance [%]
};

enum class DeltaUnit { kFrames, kMeters, kDegrees, kRadians };

/// Which pairs of poses a relative error compares.
struct DeltaOptions {
  double delta = 1.0;
  DeltaUnit unit = DeltaUnit::kFrames;
  bool all_pairs = false;             ///< overlapping pairs from every pose, not a chain of pairs
  double relative_tolerance = 0.1;    ///< how far a pair may miss delta; all_pairs only
  bool pairs_from_reference = false;  ///< measure delta on the reference, not on the estimate

  void validate() const;
};

using PosePair = std::pair<std::size_t, std::size_t>;

/// Errors, and for each the pose it belongs to (of a pair: the later one).
struct ErrorSeries {
  std::vector<double> errors;
  std::vector<std::size_t> poses;
  std::size_t dropped = 0;  ///< pairs without reference motion, which have no ratio
};

/// APE. E_i = P_i^-1 Q_i with the estimate P already aligned to the reference Q.
/// Throws InputError(kUsage) for the ratio, which needs two poses.
ErrorSeries absolute_errors(const PosePath& reference, const PosePath& estimate, Relation relation);

/// RPE. E_ij = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) over the pairs that `options` select.
/// Throws InputError(kEvaluation), with evo's words, if no pair is found.
ErrorSeries relative_errors(const PosePath& reference,
                            const PosePath& estimate,
                            Relation relation,
                            const DeltaOptions& options);

/// The pairs of `path` that lie `delta` apart; may be empty.
std::vector<PosePair> select_pairs(const PosePath& path, const DeltaOptions& options);

/// Distance along the path up to each pose [m]; starts with 0.
std::vector<double> distances_along(const PosePath& path);

}  // namespace imslam::evaluation

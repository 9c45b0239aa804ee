#pragma once

#include <string>
#include <vector>

#include "slam/evaluation/associate.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::evaluation {

/// Why stamps of the two paths do not meet, and what to do about it: another unit (nanoseconds
/// against seconds), another clock, no overlap, a bound that is too tight. One sentence.
std::string explain_mismatch(const PosePath& reference,
                             const PosePath& estimate,
                             const AssociationOptions& options);

/// Things that make figures doubtful although stamps did match: units, use of one pose for several.
std::vector<std::string> association_warnings(const PosePath& reference,
                                              const PosePath& estimate,
                                              const MatchedPaths& matched,
                                              std::size_t reused,
                                              const AssociationOptions& options);

}  // namespace imslam::evaluation

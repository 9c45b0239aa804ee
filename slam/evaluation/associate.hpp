#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slam/sensors/trajectory.hpp"

namespace imslam::evaluation {

/// How poses of two paths find each other in time.
struct AssociationOptions {
  double max_difference_s = 0.01;  ///< [s], inclusive
  double offset_s = 0.0;           ///< [s], added to the estimate's stamps
  std::optional<double> start_s;   ///< [s], reference poses before it are ignored
  std::optional<double> end_s;     ///< [s], reference poses after it are ignored
  bool interpolate = false;        ///< reference between its stamps instead of the nearest one
  double max_gap_s = 0.2;          ///< [s], no interpolation across larger holes of the reference

  void validate() const;
};

/// Two paths of equal length; pose i of one belongs to pose i of the other.
struct MatchedPaths {
  PosePath reference;
  PosePath estimate;
  std::size_t reference_poses = 0;  ///< before matching (after the crop to start and end)
  std::size_t estimate_poses = 0;
  double coverage = 0.0;       ///< matched share of the shorter path
  double time_coverage = 0.0;  ///< share of the reference's duration that the matches span
  std::vector<std::string> warnings;
};

/// For each pose of the shorter path the nearest in time of the longer one, as evo does it: in
/// file order, in doubles, the first of equally near ones; a pose of the longer path may be used
/// twice. Paths without stamps must be equally long and are matched by index.
///
/// Throws InputError(kEvaluation) that says why if nothing matches.
MatchedPaths associate(const PosePath& reference,
                       const PosePath& estimate,
                       const AssociationOptions& options = {});

/// For each of `stamps` the index of the nearest of `others` + `offset_s`, and how far it is [s].
struct Nearest {
  std::size_t index = 0;
  double difference_s = 0.0;
};
std::vector<Nearest> nearest_stamps(const std::vector<double>& stamps,
                                    const std::vector<double>& others,
                                    double offset_s);

}  // namespace imslam::evaluation

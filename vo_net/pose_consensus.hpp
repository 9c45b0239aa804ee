#pragma once

#include <optional>

#include "vo_net/pose_layer_system.hpp"

namespace imslam::vo::detail {

/// A motion that many of the points agree on.
struct Consensus {
  Estimate estimate;
  double share = 0.0;  ///< of the usable points
};

/// The motion with the most points behind it, found from small random samples: for scenes where
/// most of what is seen moves by itself, so that a descent from all points goes astray.
///
///   3 points  --Gauss-Newton from `start`-->  a motion  --all points-->  sum min(s, limit)
///
/// s as in the pose layer, disparities eliminated; `limit` is that of points which belong to the
/// motion. The samples are the same in every call. Empty if no sample gives a motion. Source of the
/// score: Torr & Zisserman, "MLESAC", CVIU 2000 (there MSAC).
std::optional<Consensus> find_consensus(const Problem& problem,
                                        const Estimate& start,
                                        double limit);

}  // namespace imslam::vo::detail

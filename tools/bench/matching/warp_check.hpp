#pragma once

#include <vector>

#include "tools/bench/matching/scene.hpp"

namespace imslam::bench {

/// Do the conventions of a data set's truth hold? Median of |I0(p) - I1(p + d + e)| [grey levels]
/// over the visible points of all scenes, with d the truth and e an error put in on purpose.
struct WarpCheck {
  double truth = 0.0;      ///< e = 0
  double one_pixel = 0.0;  ///< the least of e = (+-1, 0), (0, +-1)
  double no_motion = 0.0;  ///< d + e = 0
  int scenes = 0;          ///< that know this kind
  std::size_t points = 0;

  /// A wrong sign, unit, channel or offset makes the truth no better than its neighbours.
  bool holds() const { return truth < one_pixel && truth <= no_motion; }
};

WarpCheck check_by_warping(const std::vector<MatchScene>& scenes, vo::MatchKind kind);

}  // namespace imslam::bench

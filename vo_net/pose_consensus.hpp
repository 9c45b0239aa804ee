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

/// How the left camera has moved, as something other than vision says.
struct Foretold {
  lie::SE3d T_left0_left1;
  double sigma_rad = 0.0;
  bool translation_known = false;
  double sigma_m = 0.0;

  /// Whether what vision saw lies within 4 standard deviations.
  bool turns_alike(const lie::SE3d& T_left0_left1_seen) const;
  bool moves_alike(const lie::SE3d& T_left0_left1_seen) const;
};

/// The motion that turns, and moves if that is known, as `foretold` says and has the most points
/// behind it. With the rotation known a single point of the scene gives the translation, so every
/// point is tried and a group can be found that is far from being the majority: things that move by
/// themselves, or with the lens, each ask for a translation of their own.
///
///   t_k = X_k - R Y_k  for X_k, Y_k the point as both pairs see it
///   t   = argmin over t_k of  sum min(e^2, tau^2) over all points
///
/// e [px] is the reprojection error in left1, tau grows with sigma_rad. The same in every call.
/// Empty if there are too few points.
std::optional<Consensus> find_foretold(const Problem& problem,
                                       const Estimate& start,
                                       const Foretold& foretold);

}  // namespace imslam::vo::detail

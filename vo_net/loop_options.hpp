#pragma once

#include "slam/base/config.hpp"

namespace imslam::vo {

/// How old views are kept and recognised.
struct LoopOptions {
  int max_keyframes = 100;          ///< kept at once
  double max_memory_mb = 120.0;     ///< their images may take up; fewer are kept if need be
  int every = 5;                    ///< [frames] between two searches
  int max_edges = 2;                ///< old views that one frame is tied to, at most
  double min_gap_s = 2.0;           ///< younger views share the odometry's tracks
  double new_view = 0.7;            ///< [1] a view of less similarity to all others is kept
  double min_similarity = 0.5;      ///< [1] views less similar are not compared
  int max_points = 250;             ///< points of a view that are searched for
  int min_inliers = 40;             ///< fewer are no proof
  double min_inlier_share = 0.3;    ///< [1] of the points that should be seen
  double min_correlation = 0.8;     ///< [1] of a warped patch with its match
  double max_search = 0.12;         ///< [image widths] a less certain prediction is not tried
  double gate = 6.0;                ///< [standard deviations] between prediction and match
  double drift_factor = 3.0;        ///< [1] true over stated standard deviation of odometry sums
  double shared_error = 0.3;        ///< [1] of n points: they count as n / (1 + shared_error n)
  double rotation_floor = 2e-4;     ///< [rad] error of an edge that its points do not show
  double translation_floor = 5e-4;  ///< [1] likewise, in median depths of the scene

  void describe(Config& config);
  void validate() const;
};

}  // namespace imslam::vo

#include "vo_net/loop_options.hpp"

#include "vo_net/options_check.hpp"

namespace imslam::vo {

void LoopOptions::describe(Config& config) {
  config.field("max_keyframes", max_keyframes, "old views kept at once");
  config.field("max_memory_mb", max_memory_mb, "their images may take up [MB]");
  config.field("every", every, "between two searches [frames]");
  config.field("max_edges", max_edges, "old views that one frame is tied to, at most");
  config.field("min_gap_s", min_gap_s, "younger views are not compared [s]");
  config.field("new_view", new_view, "a view of less similarity to all others is kept [1]");
  config.field("min_similarity", min_similarity, "views less similar are not compared [1]");
  config.field("max_points", max_points, "points of a view that are searched for");
  config.field("min_inliers", min_inliers, "fewer points are no proof of a view seen again");
  config.field("min_inlier_share", min_inlier_share, "of the points that should be seen [1]");
  config.field("min_correlation", min_correlation, "of a warped patch with its match [1]");
  config.field("max_search", max_search, "a less certain prediction is not tried [image widths]");
  config.field("gate", gate, "between prediction and match [standard deviations]");
  config.field("drift_factor", drift_factor,
               "true over stated standard deviation of summed odometry [1]");
  config.field("shared_error", shared_error,
               "share of the matching variance that all points have in common [1]");
  config.field("rotation_floor", rotation_floor, "error that the points do not show [rad]");
  config.field("translation_floor", translation_floor,
               "error that the points do not show [median depths]");
}

void LoopOptions::validate() const {
  const auto share = [](const char* key, double value) {
    require(value >= 0.0 && value <= 1.0, key, value, "0 .. 1");
  };
  require(max_keyframes >= 1 && max_keyframes <= 10000, "loops.max_keyframes", max_keyframes,
          "1 .. 10000");
  require(max_memory_mb > 0.0, "loops.max_memory_mb", max_memory_mb, "> 0");
  require(every >= 1, "loops.every", every, ">= 1");
  require(max_edges >= 1 && max_edges <= 20, "loops.max_edges", max_edges, "1 .. 20");
  require(min_gap_s >= 0.0, "loops.min_gap_s", min_gap_s, ">= 0");
  require(max_points >= 20, "loops.max_points", max_points, ">= 20");
  require(min_inliers >= 10, "loops.min_inliers", min_inliers, ">= 10");
  require(min_correlation >= -1.0 && min_correlation < 1.0, "loops.min_correlation",
          min_correlation, "-1 .. 1");
  require(gate > 0.0, "loops.gate", gate, "> 0");
  require(drift_factor > 0.0, "loops.drift_factor", drift_factor, "> 0");
  require(rotation_floor >= 0.0, "loops.rotation_floor", rotation_floor, ">= 0");
  require(translation_floor >= 0.0, "loops.translation_floor", translation_floor, ">= 0");
  share("loops.new_view", new_view);
  share("loops.min_similarity", min_similarity);
  share("loops.min_inlier_share", min_inlier_share);
  share("loops.max_search", max_search);
  share("loops.shared_error", shared_error);
}

}  // namespace imslam::vo

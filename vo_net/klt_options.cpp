#include <algorithm>

#include "vo_net/klt_matcher.hpp"
#include "vo_net/options_check.hpp"
#include "vo_net/patch_aligner.hpp"

namespace imslam::vo {

void KltOptions::describe(Config& config) {
  config.field("max_points", max_points, "about how many points to follow");
  config.field("levels", levels, "of the image pyramid");
  config.field("window", window,
               "side of the patches followed over time [px], odd; 0: by the image's width");
  config.field("stereo_window", stereo_window,
               "side of the patches left to right [px], odd; 0: by the image's width");
  config.field("smoothing", smoothing, "sigma of the Gaussian on the images [px], 0: none");
  config.field("min_correlation", min_correlation, "of a patch with its match [1]");
  config.field("max_round_trip", max_round_trip, "forward and backward must meet within [px]");
  config.field("max_row_error", max_row_error, "between left and right [px]");
  config.field("stereo_along_row", stereo_along_row, "search right images on the same row only");
  config.field("max_disparity", max_disparity, "[image widths]");
  config.field("min_quality", min_quality,
               "smaller eigenvalue of a corner's structure tensor [grey^2/px^2]");
  config.field("sigma_floor", sigma_floor, "error of a match that texture does not explain [px]");
  config.field("keyframe_age", keyframe_age, "skip edges reach back so far [frames], 0: none");
  config.field("keyframe_overlap", keyframe_overlap,
               "a keyframe with a smaller share of the points is replaced [1]");
}

void KltOptions::validate() const {
  const auto is_window = [](int w) {
    return w == 0 || (w >= 5 && w <= PatchTemplate::kMaxWindow && w % 2 == 1);
  };
  require(max_points >= 20 && max_points <= 100000, "vo.klt.max_points", max_points,
          "20 .. 100000");
  require(levels >= 1 && levels <= 8, "vo.klt.levels", levels, "1 .. 8");
  require(is_window(window), "vo.klt.window", window, "an odd number in 5 .. 23, or 0");
  require(is_window(stereo_window), "vo.klt.stereo_window", stereo_window,
          "an odd number in 5 .. 23, or 0");
  require(smoothing >= 0.0 && smoothing <= 5.0, "vo.klt.smoothing", smoothing, "0 .. 5");
  require(min_correlation >= -1.0 && min_correlation < 1.0, "vo.klt.min_correlation",
          min_correlation, "-1 .. 1");
  require(max_round_trip > 0.0, "vo.klt.max_round_trip", max_round_trip, "> 0");
  require(max_row_error > 0.0, "vo.klt.max_row_error", max_row_error, "> 0");
  require(max_disparity > 0.0 && max_disparity <= 1.0, "vo.klt.max_disparity", max_disparity,
          "0 .. 1");
  require(min_quality >= 0.0, "vo.klt.min_quality", min_quality, ">= 0");
  require(sigma_floor > 0.0, "vo.klt.sigma_floor", sigma_floor, "> 0");
  require(keyframe_age >= 0 && keyframe_age <= 100, "vo.klt.keyframe_age", keyframe_age,
          "0 .. 100");
  require(keyframe_overlap >= 0.0 && keyframe_overlap <= 1.0, "vo.klt.keyframe_overlap",
          keyframe_overlap, "0 .. 1");
}

KltOptions KltOptions::for_width(int width) const {
  constexpr int kWidthPerPixel = 50;
  const int suitable = std::clamp(width / kWidthPerPixel, 9, 15) | 1;
  KltOptions resolved = *this;
  if (window == 0) resolved.window = suitable;
  if (stereo_window == 0) resolved.stereo_window = suitable;
  return resolved;
}

}  // namespace imslam::vo

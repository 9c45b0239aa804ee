#include "vo_net/learned_options.hpp"

#include "vo_net/klt_matcher.hpp"
#include "vo_net/options_check.hpp"
#include "vo_net/patch_aligner.hpp"

namespace imslam::vo {

void LearnedMatcherOptions::describe(Config& config) {
  config.field("weights", weights, "file of the matching network; empty: the shipped one");
  config.field("max_points", max_points, "about how many points to follow");
  config.field("min_confidence", min_confidence, "a match less likely to be right is none [1]");
  config.field("max_width", max_width,
               "wider images are shrunk for the network, by a whole factor [px]");
  config.field("max_width_hard", max_width_hard, "likewise in blurred, dark or noisy frames [px]");
  config.field("min_contrast", min_contrast, "less around a point shows nothing [grey levels]");
  config.field("polish", polish, "Lucas-Kanade at full size, from the network's answer");
  config.field("coarse_polish", coarse_polish,
               "then at half size, quarter size ...: how many times smaller at most [halvings]");
  config.field("polish_window", polish_window,
               "side of its patches [px], odd; 0: by the image's width");
  config.field("max_polish_sigma", max_polish_sigma, "less certain matches are not polished [px]");
  config.field("max_polish_move", max_polish_move, "from the network's answer at most [px]");
  config.field("min_polish_correlation", min_polish_correlation, "of a patch with its match [1]");
  config.field("max_row_error", max_row_error, "between left and right [px]");
  config.field("smoothing", smoothing, "sigma of the Gaussian before Lucas-Kanade [px]");
  config.field("sigma_floor", sigma_floor, "error of a match that nothing explains [px]");
}

void LearnedMatcherOptions::validate() const {
  require(max_points >= 20 && max_points <= 100000, "vo.learned.max_points", max_points,
          "20 .. 100000");
  require(min_confidence >= 0.0 && min_confidence < 1.0, "vo.learned.min_confidence",
          min_confidence, "0 .. 1, not 1");
  require(max_width >= 64, "vo.learned.max_width", max_width, ">= 64");
  require(max_width_hard >= 64, "vo.learned.max_width_hard", max_width_hard, ">= 64");
  require(min_contrast > 0.0 && min_contrast <= 100.0, "vo.learned.min_contrast", min_contrast,
          "0 .. 100, not 0");
  require(coarse_polish >= 0 && coarse_polish <= 4, "vo.learned.coarse_polish", coarse_polish,
          "0 .. 4");
  require(polish_window == 0 || (polish_window >= 5 && polish_window <= PatchTemplate::kMaxWindow &&
                                 polish_window % 2 == 1),
          "vo.learned.polish_window", polish_window, "an odd number in 5 .. 23, or 0");
  require(max_polish_sigma >= 0.0, "vo.learned.max_polish_sigma", max_polish_sigma, ">= 0");
  require(max_polish_move > 0.0, "vo.learned.max_polish_move", max_polish_move, "> 0");
  require(min_polish_correlation >= -1.0 && min_polish_correlation < 1.0,
          "vo.learned.min_polish_correlation", min_polish_correlation, "-1 .. 1");
  require(max_row_error > 0.0, "vo.learned.max_row_error", max_row_error, "> 0");
  require(smoothing >= 0.0 && smoothing <= 5.0, "vo.learned.smoothing", smoothing, "0 .. 5");
  require(sigma_floor > 0.0, "vo.learned.sigma_floor", sigma_floor, "> 0");
}

LearnedMatcherOptions LearnedMatcherOptions::for_width(int width) const {
  LearnedMatcherOptions resolved = *this;
  if (polish_window == 0) resolved.polish_window = KltOptions().for_width(width).window;
  return resolved;
}

}  // namespace imslam::vo

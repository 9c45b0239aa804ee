#include "slam/base/config.hpp"
#include "slam/training/augmentation.hpp"
#include "slam/training/bounds.hpp"

namespace imslam::training {

void AugmentationOptions::describe(Config& config) {
  config.field("seed", seed, "of all degradations");
  config.field("exposure_share", exposure_share, "triplets whose exposure jumps");
  config.field("least_gain", least_gain, "smallest factor of a jump");
  config.field("most_gain", most_gain, "largest factor of a jump");
  config.field("gamma_share", gamma_share, "triplets with a bent response curve");
  config.field("most_gamma", most_gamma, "largest exponent; its inverse is the smallest");
  config.field("dark_share", dark_share, "triplets in the dark");
  config.field("darkest", darkest, "least share of light that is left");
  config.field("vignetting_share", vignetting_share, "triplets with dark corners");
  config.field("vignetting", vignetting, "most loss of light in the corners");
  config.field("haze_share", haze_share, "triplets in haze");
  config.field("haze", haze, "most loss of contrast");
  config.field("motion_blur_share", motion_blur_share, "triplets with motion blur");
  config.field("motion_blur", motion_blur, "longest smear [px]");
  config.field("defocus_share", defocus_share, "triplets out of focus");
  config.field("defocus", defocus, "most blur, sigma [px]");
  config.field("noise_share", noise_share, "triplets with noise");
  config.field("read_noise", read_noise, "most read noise, sigma [grey levels]");
  config.field("shot_noise", shot_noise, "most shot noise, variance per grey level");
  config.field("hot_pixel_share", hot_pixel_share, "triplets with hot pixels");
  config.field("hot_pixels", hot_pixels, "most hot pixels per view");
  config.field("occluder_share", occluder_share, "triplets with moving rectangles");
  config.field("occluders", occluders, "most moving rectangles");
  config.field("occluder_flow", occluder_flow, "sigma of their flow [px]");
  config.field("occluder_disparity", occluder_disparity, "their largest disparity [px]");
}

void AugmentationOptions::validate() const {
  require_within("exposure_share", exposure_share, 0.0, 1.0);
  require_within("least_gain", least_gain, 0.01, 1.0);
  require_within("most_gain", most_gain, 1.0, 100.0);
  require_within("gamma_share", gamma_share, 0.0, 1.0);
  require_within("most_gamma", most_gamma, 1.0, 5.0);
  require_within("dark_share", dark_share, 0.0, 1.0);
  require_within("darkest", darkest, 0.001, 1.0);
  require_within("vignetting_share", vignetting_share, 0.0, 1.0);
  require_within("vignetting", vignetting, 0.0, 1.0);
  require_within("haze_share", haze_share, 0.0, 1.0);
  require_within("haze", haze, 0.0, 1.0);
  require_within("motion_blur_share", motion_blur_share, 0.0, 1.0);
  require_within("motion_blur", motion_blur, 0.0, 48.0);
  require_within("defocus_share", defocus_share, 0.0, 1.0);
  require_within("defocus", defocus, 0.0, 10.0);
  require_within("noise_share", noise_share, 0.0, 1.0);
  require_within("read_noise", read_noise, 0.0, 255.0);
  require_within("shot_noise", shot_noise, 0.0, 100.0);
  require_within("hot_pixel_share", hot_pixel_share, 0.0, 1.0);
  require_within("hot_pixels", hot_pixels, 0, 10000);
  require_within("occluder_share", occluder_share, 0.0, 1.0);
  require_within("occluders", occluders, 0, 100);
  require_within("occluder_flow", occluder_flow, 0.0, 1000.0);
  require_within("occluder_disparity", occluder_disparity, 1.0, 1000.0);
}

}  // namespace imslam::training

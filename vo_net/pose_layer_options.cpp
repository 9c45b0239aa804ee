#include "slam/base/error.hpp"
#include "vo_net/options_check.hpp"
#include "vo_net/pose_layer.hpp"

namespace imslam::vo {

void PoseLayerOptions::describe(Config& config) {
  config.field("kernel", kernel, {"none", "huber", "cauchy", "geman_mcclure"},
               "robust kernel of the pose layer");
  config.field("kernel_width", kernel_width, "where the kernel bends [standard deviations]");
  config.field("adapt_noise_scale", adapt_noise_scale,
               "estimate the scale of the matcher's standard deviations in each frame");
  config.field("min_noise_scale", min_noise_scale, "lower bound of that scale [1]");
  config.field("max_noise_scale", max_noise_scale,
               "beyond this scale the points have no motion in common [1]");
  config.field("start_iterations", start_iterations, "iterations with a narrowing kernel");
  config.field("consensus_share", consensus_share,
               "a smaller share of inliers: motions of random samples are tried too [1]; 0: never");
  config.field("max_iterations", max_iterations, "iterations after the start");
  config.field("tolerance", tolerance, "last step [standard deviations of the pose]");
  config.field("inlier_threshold", inlier_threshold, "[standard deviations]");
  config.field("min_inliers", min_inliers, "fewer inliers: no motion is reported");
  config.field("max_sigma_translation", max_sigma_translation,
               "less certain motions are not reported [m]");
  config.field("max_sigma_rotation", max_sigma_rotation,
               "less certain motions are not reported [rad]");
}

void PoseLayerOptions::validate() const {
  require(kernel_width > 0.0, "vo.pose.kernel_width", kernel_width, "> 0");
  require(min_noise_scale > 0.0, "vo.pose.min_noise_scale", min_noise_scale, "> 0");
  require(consensus_share >= 0.0 && consensus_share <= 1.0, "vo.pose.consensus_share",
          consensus_share, "0 .. 1");
  require(max_noise_scale >= min_noise_scale, "vo.pose.max_noise_scale", max_noise_scale,
          ">= vo.pose.min_noise_scale");
  require(start_iterations >= 1, "vo.pose.start_iterations", start_iterations, ">= 1");
  require(max_iterations >= 1, "vo.pose.max_iterations", max_iterations, ">= 1");
  require(tolerance > 0.0, "vo.pose.tolerance", tolerance, "> 0");
  require(inlier_threshold > 0.0, "vo.pose.inlier_threshold", inlier_threshold, "> 0");
  require(min_inliers >= 3, "vo.pose.min_inliers", min_inliers, ">= 3");
  require(max_sigma_translation > 0.0, "vo.pose.max_sigma_translation", max_sigma_translation,
          "> 0");
  require(max_sigma_rotation > 0.0, "vo.pose.max_sigma_rotation", max_sigma_rotation, "> 0");
}

RobustKernel PoseLayerOptions::robust_kernel() const {
  if (kernel == "none") return RobustKernel::kNone;
  if (kernel == "huber") return RobustKernel::kHuber;
  if (kernel == "cauchy") return RobustKernel::kCauchy;
  if (kernel == "geman_mcclure") return RobustKernel::kGemanMcClure;
  throw InputError(
      "vo.pose.kernel: expected none, huber, cauchy or geman_mcclure, got '" + kernel + "'",
      ExitCode::kUsage);
}

}  // namespace imslam::vo

#include "vo_net/keyframe_match.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "vo_net/keyframe_comparison.hpp"

namespace imslam::vo {

KeyframeMatcher::KeyframeMatcher(const LoopOptions& options,
                                 const VoOptions& vo,
                                 const StereoCamera& camera)
    : options_(options), vo_(vo), camera_(camera) {
  options_.validate();
  vo_.klt = vo.klt.for_width(camera.width);
}

std::optional<RelativeMotion> KeyframeMatcher::match(const Keyframe& keyframe,
                                                     const CurrentView& view,
                                                     std::int64_t time_ns,
                                                     const PredictedMotion& predicted,
                                                     double disparity_offset) const {
  const KeyframeComparison comparison(options_, vo_, camera_, keyframe, view, disparity_offset);
  const std::optional<lie::SE3d> first = comparison.scout(predicted);
  if (!first) return std::nullopt;
  const std::optional<PoseLayerResult> pose = comparison.measure(*first);
  if (!pose) return std::nullopt;

  RelativeMotion motion;
  motion.time0_ns = keyframe.time_ns;
  motion.time1_ns = time_ns;
  motion.T_body0_body1 = pose->T_body0_body1;
  motion.covariance =
      pose->covariance * (1.0 + options_.shared_error * static_cast<double>(pose->inliers));
  const double depth_m = camera_.fx * camera_.baseline_m / keyframe.median_disparity;
  motion.covariance.diagonal().head<3>().array() +=
      std::pow(options_.translation_floor * depth_m, 2);
  motion.covariance.diagonal().tail<3>().array() += std::pow(options_.rotation_floor, 2);
  motion.J_disparity_offset = pose->J_disparity_offset;
  motion.J_focal_error = pose->J_focal_error;
  motion.disparity_offset = disparity_offset;
  motion.inliers = pose->inliers;
  motion.valid = true;

  const Eigen::Matrix<double, 6, 1> difference =
      (predicted.T_body0_body1.inverse() * motion.T_body0_body1).log();
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> expected(predicted.covariance + motion.covariance);
  const double distance = difference.dot(expected.solve(difference));
  if (!(distance <= options_.gate * options_.gate)) return std::nullopt;
  return motion;
}

}  // namespace imslam::vo

#include "vo_net/match_labels.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace imslam::vo {
namespace {

using nn::Index;

constexpr int kRounds = 4;               // of Newton's method in one unknown
constexpr double kStep_px = 1e-4;        // of the difference quotient
constexpr double kLeastDisparity = 0.1;  // [px] beyond it the depth is anybody's guess

/// What is measured of a point, [u v disparity1], if its true disparity in the first pair is d.
Eigen::Vector3d seen_after(const StereoCamera& camera,
                           const lie::SE3d& T_left1_left0,
                           const Eigen::Vector2d& left0,
                           double d) {
  return camera.project(T_left1_left0 *
                        camera.back_project(Eigen::Vector3d(left0.x(), left0.y(), d)));
}

/// The most likely d at a given motion; empty where the point would be behind the camera.
std::optional<double> most_likely_disparity(const StereoCamera& camera,
                                            const lie::SE3d& T_left1_left0,
                                            const Correspondence& c,
                                            double offset) {
  double d = std::max(c.disparity0 - offset, kLeastDisparity);
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector3d at = seen_after(camera, T_left1_left0, c.left0, d);
    const Eigen::Vector3d slope =
        (seen_after(camera, T_left1_left0, c.left0, d + kStep_px) - at) / kStep_px;
    if (!at.allFinite() || !slope.allFinite()) return std::nullopt;
    const Eigen::Vector2d e = at.head<2>() - c.left1;
    const Eigen::Vector2d J = slope.head<2>();
    const double e0 = d + offset - c.disparity0;
    const double e1 = at.z() + offset - c.disparity1;
    const double g = c.disparity0_information * e0 + J.dot(c.flow_information * e) +
                     c.disparity1_information * slope.z() * e1;
    const double h = c.disparity0_information + J.dot(c.flow_information * J) +
                     c.disparity1_information * slope.z() * slope.z();
    if (!(h > 0.0)) return std::nullopt;
    d = std::max(d - g / h, kLeastDisparity);
  }
  return d;
}

void resize(MatchTruth<float>& truth, Index points, Index dimensions) {
  truth.displacement = nn::Tensor<float>({1, points, dimensions});
  truth.valid = nn::Tensor<float>({1, points});
  truth.visible = nn::Tensor<float>({1, points});
}

}  // namespace

MatchLabels match_labels(const Correspondences& correspondences,
                         const PoseLayerResult& pose,
                         const StereoCamera& camera,
                         const lie::SE3d& T_body0_body1,
                         double disparity_offset,
                         int shrink,
                         double wrong_px) {
  const auto count = static_cast<Index>(correspondences.size());
  MatchLabels labels;
  resize(labels.flow, count, 2);
  resize(labels.stereo0, count, 1);
  resize(labels.stereo1, count, 1);
  const lie::SE3d T_left1_left0 =
      camera.T_body_left.inverse() * T_body0_body1.inverse() * camera.T_body_left;
  for (Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Correspondence& c = correspondences[k];
    const auto d = most_likely_disparity(camera, T_left1_left0, c, disparity_offset);
    if (!d) continue;
    const Eigen::Vector3d at = seen_after(camera, T_left1_left0, c.left0, *d);
    const Eigen::Vector2d flow = (at.head<2>() - c.left0) / shrink;
    labels.flow.displacement[2 * i] = static_cast<float>(flow.x());
    labels.flow.displacement[2 * i + 1] = static_cast<float>(flow.y());
    labels.stereo0.displacement[i] = static_cast<float>(-(*d + disparity_offset) / shrink);
    labels.stereo1.displacement[i] = static_cast<float>(-(at.z() + disparity_offset) / shrink);
    const bool right = pose.is_inlier[k] != 0;
    const bool wrong = !right && (at.head<2>() - c.left1).norm() > wrong_px;
    labels.flow.valid[i] = right || wrong ? 1.0F : 0.0F;
    labels.flow.visible[i] = right ? 1.0F : 0.0F;
    for (MatchTruth<float>* const stereo : {&labels.stereo0, &labels.stereo1}) {
      stereo->valid[i] = right ? 1.0F : 0.0F;  // a wrong flow says nothing about the stereo matches
      stereo->visible[i] = right ? 1.0F : 0.0F;
    }
  }
  return labels;
}

}  // namespace imslam::vo

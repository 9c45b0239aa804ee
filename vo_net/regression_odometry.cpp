#include "vo_net/regression_odometry.hpp"

#include <algorithm>
#include <cmath>

#include "vo_net/flow_grid.hpp"
#include "vo_net/regressed_motion.hpp"

namespace imslam::vo {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kFocalStep = 1e-2;  // [1] of the difference quotient: far above float's noise

bool within(const Matrix6& covariance, const PoseLayerOptions& limits) {
  const auto largest = [](const Eigen::Matrix3d& C) { return C.diagonal().maxCoeff(); };
  return covariance.allFinite() &&
         largest(covariance.topLeftCorner<3, 3>()) <
             limits.max_sigma_translation * limits.max_sigma_translation &&
         largest(covariance.bottomRightCorner<3, 3>()) <
             limits.max_sigma_rotation * limits.max_sigma_rotation;
}

}  // namespace

struct RegressionHead::Regressed {
  MotionLook look;
  ScaleResult scale;
  lie::SE3d T_left0_left1;
};

void RegressionOptions::describe(Config& config) {
  config.field("weights", weights, "file of the pose head; empty: the shipped one");
  config.section("scale", scale);
}

void RegressionOptions::validate() const { scale.validate(); }

RegressionHead::RegressionHead(const RegressionOptions& options,
                               std::shared_ptr<const PoseHead<float>> network)
    : options_(options), network_(std::move(network)) {
  options_.validate();
  expects(network_ != nullptr, "RegressionHead: needs a network");
}

RegressionHead::Regressed RegressionHead::regress(const Correspondences& correspondences,
                                                  const StereoCamera& camera,
                                                  double disparity_offset) const {
  Regressed r;
  nn::Tensor<float> grid = FlowGrid::make(1);
  FlowGrid::fill(correspondences, camera, 0, grid);
  nn::Tape<float> tape(nn::Mode::kInference);
  r.look = motion_look(tape, network_->forward(tape, tape.constant(grid)).back());
  const MotionDirection motion{lie::SO3d::exp(r.look.theta), r.look.direction};
  r.scale = correct_scale(correspondences, camera, motion, options_.scale, disparity_offset);
  r.T_left0_left1 = lie::SE3d(motion.R_left0_left1, r.scale.scale * r.look.direction);
  return r;
}

PoseLayerResult RegressionHead::solve(const Correspondences& correspondences,
                                      const StereoCamera& camera,
                                      const PoseLayerOptions& limits,
                                      double disparity_offset) const {
  PoseLayerResult result;
  result.disparity_offset = disparity_offset;
  result.is_inlier.assign(correspondences.size(), 0);
  for (const Correspondence& c : correspondences) {
    result.disparities.push_back(c.disparity0 - disparity_offset);
  }
  const Regressed r = regress(correspondences, camera, disparity_offset);
  result.iterations = r.scale.rounds;
  result.converged = r.scale.converged;
  result.noise_scale = r.scale.noise_scale;
  result.inliers = r.scale.inliers;
  result.is_inlier = r.scale.is_inlier;
  if (r.scale.state == ScaleState::kUnknown || !r.T_left0_left1.matrix().allFinite()) return result;
  result.T_body0_body1 = in_body(r.T_left0_left1, camera);
  const Matrix6 adjoint = camera.T_body_left.adjoint();
  result.covariance = adjoint * regressed_covariance(r.look, r.scale).value * adjoint.transpose();
  result.valid = r.scale.inliers >= limits.min_inliers && within(result.covariance, limits);
  if (!result.valid) return result;

  Eigen::Matrix<double, 6, 1> by_offset = Eigen::Matrix<double, 6, 1>::Zero();
  by_offset.head<3>() =
      r.T_left0_left1.rotation().inverse() * (r.scale.J_disparity_offset * r.look.direction).eval();
  result.J_disparity_offset = adjoint * by_offset;
  StereoCamera longer = camera;
  longer.fx *= 1.0 + kFocalStep;
  longer.fy *= 1.0 + kFocalStep;
  longer.baseline_m /= 1.0 + kFocalStep;
  const Regressed with_longer = regress(correspondences, longer, disparity_offset);
  const lie::SE3d moved =
      result.T_body0_body1.inverse() * in_body(with_longer.T_left0_left1, camera);
  result.J_focal_error = moved.log() / kFocalStep;
  return result;
}

}  // namespace imslam::vo

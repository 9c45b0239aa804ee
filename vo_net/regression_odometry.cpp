#include "vo_net/regression_odometry.hpp"

#include <algorithm>
#include <cmath>

#include "vo_net/flow_grid.hpp"

namespace imslam::vo {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kFocalStep = 1e-2;    // [1] of the difference quotient: far above float's noise
constexpr double kContradicted = 1.0;  // sigma of a direction that the points speak against

/// What the network says.
struct Look {
  Eigen::Vector3d theta;
  Eigen::Vector3d direction;
  Eigen::Vector3d sigma_theta;  ///< [rad]
  double sigma_direction = 0.0;
};

Look look_at(const PoseHead<float>& network,
             const Correspondences& correspondences,
             const StereoCamera& camera) {
  nn::Tensor<float> grid = FlowGrid::make(1);
  FlowGrid::fill(correspondences, camera, 0, grid);
  nn::Tape<float> tape(nn::Mode::kInference);
  const PoseHeadOutput answer = network.forward(tape, tape.constant(grid)).back();
  const auto vector = [&](nn::Var v) {
    const float* const x = tape.data(v);
    return Eigen::Vector3d(static_cast<double>(x[0]), static_cast<double>(x[1]),
                           static_cast<double>(x[2]));
  };
  Look look;
  look.theta = vector(answer.rotation);
  look.direction = vector(answer.direction).normalized();
  look.sigma_theta = vector(answer.log_sigma_rotation).array().exp();
  look.sigma_direction = std::exp(static_cast<double>(tape.data(answer.log_sigma_direction)[0]));
  return look;
}

/// Covariance of T_left0_left1, right tangent.
Matrix6 covariance_of(const Look& look, const ScaleResult& scale) {
  const Eigen::Vector3d& d = look.direction;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
  const double sigma_d =
      scale.state == ScaleState::kBackwards ? kContradicted : look.sigma_direction;
  Matrix6 C = Matrix6::Zero();  // of [direction theta]
  C.topLeftCorner<3, 3>() = sigma_d * sigma_d * across;
  C.bottomRightCorner<3, 3>() = look.sigma_theta.cwiseAbs2().asDiagonal();
  // theta's error is on the left side of J_r: the rotation's right tangent is J_r dtheta.
  const Eigen::Matrix3d J_r = lie::SO3d::right_jacobian(look.theta);
  Matrix6 J = Matrix6::Zero();  // d[p tangent]/d[direction theta]
  J.topLeftCorner<3, 3>() =
      scale.scale * Eigen::Matrix3d::Identity() + d * scale.J_direction.transpose();
  J.topRightCorner<3, 3>() = d * scale.J_rotation.transpose() * J_r;
  J.bottomRightCorner<3, 3>() = J_r;
  Matrix6 result = J * C * J.transpose();
  // The errors of theta and d go together in a way that the network does not tell: claiming the
  // part that comes from the scale alone made the whole far too sure (NEES), so none is claimed.
  result.topRightCorner<3, 3>().setZero();
  result.bottomLeftCorner<3, 3>().setZero();
  // Standing still there is no direction: the length's uncertainty goes everywhere.
  const Eigen::Matrix3d along = scale.state == ScaleState::kStandingStill
                                    ? Eigen::Matrix3d::Identity().eval()
                                    : (d * d.transpose()).eval();
  result.topLeftCorner<3, 3>() += scale.sigma * scale.sigma * along;
  Matrix6 turn = Matrix6::Identity();  // p_left0 to the right tangent's rho
  turn.topLeftCorner<3, 3>() = lie::SO3d::exp(-look.theta).matrix();
  return turn * result * turn.transpose();
}

lie::SE3d in_body(const lie::SE3d& T_left0_left1, const StereoCamera& camera) {
  return camera.T_body_left * T_left0_left1 * camera.T_body_left.inverse();
}

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
  Look look;
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
  r.look = look_at(*network_, correspondences, camera);
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
  result.covariance = adjoint * covariance_of(r.look, r.scale) * adjoint.transpose();
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

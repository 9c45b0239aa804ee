#include "vo_net/regressed_motion.hpp"

#include <cmath>

namespace imslam::vo {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kContradicted = 1.0;  // sigma of a direction that the points speak against

}  // namespace

template <typename S>
MotionLook motion_look(const nn::Tape<S>& tape, const PoseHeadOutput& answer) {
  const auto vector = [&](nn::Var v) {
    const S* const x = tape.data(v);
    return Eigen::Vector3d(static_cast<double>(x[0]), static_cast<double>(x[1]),
                           static_cast<double>(x[2]));
  };
  MotionLook look;
  look.theta = vector(answer.rotation);
  look.direction = vector(answer.direction).normalized();
  look.sigma_theta = vector(answer.log_sigma_rotation).array().exp();
  look.sigma_direction = std::exp(static_cast<double>(tape.data(answer.log_sigma_direction)[0]));
  return look;
}

template MotionLook motion_look(const nn::Tape<float>&, const PoseHeadOutput&);
template MotionLook motion_look(const nn::Tape<double>&, const PoseHeadOutput&);

RegressedCovariance regressed_covariance(const MotionLook& look, const ScaleResult& scale) {
  RegressedCovariance result;
  const Eigen::Vector3d& d = look.direction;
  result.across = Eigen::Matrix3d::Identity() - d * d.transpose();
  result.direction_counts = scale.state != ScaleState::kBackwards;
  result.sigma_direction = result.direction_counts ? look.sigma_direction : kContradicted;
  Matrix6 C = Matrix6::Zero();  // of [direction theta]
  C.topLeftCorner<3, 3>() = result.sigma_direction * result.sigma_direction * result.across;
  C.bottomRightCorner<3, 3>() = look.sigma_theta.cwiseAbs2().asDiagonal();
  // theta's error is on the left side of J_r: the rotation's right tangent is J_r dtheta.
  const Eigen::Matrix3d J_r = lie::SO3d::right_jacobian(look.theta);
  result.J = Matrix6::Zero();  // d[p tangent]/d[direction theta]
  result.J.topLeftCorner<3, 3>() =
      scale.scale * Eigen::Matrix3d::Identity() + d * scale.J_direction.transpose();
  result.J.topRightCorner<3, 3>() = d * scale.J_rotation.transpose() * J_r;
  result.J.bottomRightCorner<3, 3>() = J_r;
  Matrix6 spread = result.J * C * result.J.transpose();
  // The errors of theta and d go together in a way that the network does not tell: claiming the
  // part that comes from the scale alone made the whole far too sure (NEES), so none is claimed.
  spread.topRightCorner<3, 3>().setZero();
  spread.bottomLeftCorner<3, 3>().setZero();
  // Standing still there is no direction: the length's uncertainty goes everywhere.
  const Eigen::Matrix3d along = scale.state == ScaleState::kStandingStill
                                    ? Eigen::Matrix3d::Identity().eval()
                                    : (d * d.transpose()).eval();
  spread.topLeftCorner<3, 3>() += scale.sigma * scale.sigma * along;
  result.turn = Matrix6::Identity();  // p_left0 to the right tangent's rho
  result.turn.topLeftCorner<3, 3>() = lie::SO3d::exp(-look.theta).matrix();
  result.value = result.turn * spread * result.turn.transpose();
  return result;
}

lie::SE3d in_body(const lie::SE3d& T_left0_left1, const StereoCamera& camera) {
  return camera.T_body_left * T_left0_left1 * camera.T_body_left.inverse();
}

}  // namespace imslam::vo

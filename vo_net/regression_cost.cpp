#include "vo_net/regression_cost.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "vo_net/flow_grid.hpp"
#include "vo_net/motion_noise.hpp"
#include "vo_net/regressed_motion.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// dU/d(answer), number by number.
struct LookSlopes {
  Eigen::Vector3d theta;
  Eigen::Vector3d direction;
  Eigen::Vector3d log_sigma_theta;
  double log_sigma_direction = 0.0;
};

/// dU/d[theta d] from dU/d(right tangent of T_left0_left1):
///   drho = R^T dp,  dp = (s I + d J_d^T) dd + d J_R^T dphi,  dphi = J_r(theta) dtheta
void motion_slopes(const MotionLook& look,
                   const ScaleResult& scale,
                   const Vector6& by_left,
                   LookSlopes& slopes) {
  const Eigen::Vector3d by_p = lie::SO3d::exp(look.theta) * Eigen::Vector3d(by_left.head<3>());
  const double along = look.direction.dot(by_p);
  slopes.direction = scale.scale * by_p + scale.J_direction * along;
  const Eigen::Vector3d by_phi = by_left.tail<3>() + scale.J_rotation * along;
  slopes.theta = lie::SO3d::right_jacobian(look.theta).transpose() * by_phi;
}

/// dU/d(log sigmas) from dU/d(covariance of T_left0_left1).
void sigma_slopes(const MotionLook& look,
                  const RegressedCovariance& covariance,
                  const Matrix6& by_left,
                  LookSlopes& slopes) {
  Matrix6 by_spread = covariance.turn.transpose() * by_left * covariance.turn;
  by_spread.topRightCorner<3, 3>().setZero();
  by_spread.bottomLeftCorner<3, 3>().setZero();
  const Matrix6 by_C = covariance.J.transpose() * by_spread * covariance.J;
  slopes.log_sigma_theta =
      2.0 * look.sigma_theta.cwiseAbs2().cwiseProduct(by_C.diagonal().tail<3>());
  const double variance = look.sigma_direction * look.sigma_direction;
  slopes.log_sigma_direction =
      covariance.direction_counts
          ? 2.0 * variance * (covariance.across * by_C.topLeftCorner<3, 3>()).trace()
          : 0.0;
}

/// Keeps 10 + 2 numbers for the way back: [theta d log_sigma_theta log_sigma_d noise].
template <typename S>
double* kept(nn::Tape<S>& tape, const LookSlopes& slopes, double by_a, double by_b) {
  double* const numbers = tape.template keep<double>(12);
  Eigen::Map<Eigen::Matrix<double, 12, 1>> all(numbers);
  all << slopes.theta, slopes.direction, slopes.log_sigma_theta, slopes.log_sigma_direction, by_a,
      by_b;
  return numbers;
}

template <typename S>
void send(nn::Tape<S>& tape, Var v, const double* slopes, Index count, double dU) {
  if (!tape.wants_gradient(v)) return;
  S* const to = tape.gradient_data(v);
  for (Index i = 0; i < count; ++i) to[i] += static_cast<S>(dU * slopes[i]);
}

template <typename S>
Vector6 factors_of(const nn::Tape<S>& tape, Var noise) {
  if (!noise) return Vector6::Ones();
  return noise_factors(static_cast<double>(tape.data(noise)[0]),
                       static_cast<double>(tape.data(noise)[1]));
}

}  // namespace

template <typename S>
RegressedMotion regression_cost(nn::Tape<S>& tape,
                                const PoseHead<S>& network,
                                const Correspondences& correspondences,
                                const MotionRecipe& recipe,
                                const ScaleOptions& options,
                                Var noise,
                                const MotionCost& cost) {
  nn::Tensor<float> grid = FlowGrid::make(1);
  FlowGrid::fill(correspondences, recipe.camera, 0, grid);
  const Var input = tape.make(grid.shape());
  std::copy_n(grid.data(), grid.size(), tape.data(input));
  RegressedMotion result;
  result.looks = network.forward(tape, input);
  result.cost = tape.make({});
  tape.data(result.cost)[0] = S(0);
  const PoseHeadOutput answer = result.looks.back();
  const MotionLook look = motion_look(tape, answer);
  const MotionDirection direction{lie::SO3d::exp(look.theta), look.direction};
  const ScaleResult scale =
      correct_scale(correspondences, recipe.camera, direction, options, recipe.disparity_offset);
  if (scale.state == ScaleState::kUnknown || !scale.converged) return result;

  const RegressedCovariance covariance = regressed_covariance(look, scale);
  const Matrix6 adjoint = recipe.camera.T_body_left.adjoint();
  const Vector6 factors = factors_of(tape, noise);
  const Matrix6 F = factors.asDiagonal();
  RelativeMotion motion;
  motion.time0_ns = recipe.time0_ns;
  motion.time1_ns = recipe.time1_ns;
  motion.T_body0_body1 =
      in_body(lie::SE3d(direction.R_left0_left1, scale.scale * look.direction), recipe.camera);
  motion.covariance = F * adjoint * covariance.value * adjoint.transpose() * F;
  motion.inliers = scale.inliers;
  motion.valid = true;
  const MotionSlope slope = cost(motion);
  if (!std::isfinite(slope.cost) || !slope.by_motion.allFinite()) return result;
  result.usable = true;
  tape.data(result.cost)[0] = static_cast<S>(slope.cost);

  LookSlopes slopes;
  motion_slopes(look, scale, adjoint.transpose() * slope.by_motion, slopes);
  sigma_slopes(look, covariance, adjoint.transpose() * F * slope.by_covariance * F * adjoint,
               slopes);
  const Vector6 rows = 2.0 * slope.by_covariance.cwiseProduct(motion.covariance).rowwise().sum();
  const double* const back = kept(tape, slopes, rows.head<3>().sum(), rows.tail<3>().sum());
  const Var y = result.cost;
  tape.record(y,
              {answer.rotation, answer.direction, answer.log_sigma_rotation,
               answer.log_sigma_direction, noise},
              [=](nn::Tape<S>& t) {
                const double dU = static_cast<double>(t.gradient_data(y)[0]);
                send(t, answer.rotation, back, 3, dU);
                send(t, answer.direction, back + 3, 3, dU);
                send(t, answer.log_sigma_rotation, back + 6, 3, dU);
                send(t, answer.log_sigma_direction, back + 9, 1, dU);
                if (noise) send(t, noise, back + 10, 2, dU);
              });
  return result;
}

#define INSTANTIATE(S)                                                                  \
  template RegressedMotion regression_cost(nn::Tape<S>&, const PoseHead<S>&,            \
                                           const Correspondences&, const MotionRecipe&, \
                                           const ScaleOptions&, Var, const MotionCost&);
INSTANTIATE(float)
INSTANTIATE(double)

}  // namespace imslam::vo

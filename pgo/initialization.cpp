#include "pgo/initialization.hpp"

#include <cmath>

#include "pgo/gyro_bias.hpp"
#include "pgo/velocity_problem.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::pgo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using lie::SO3d;

constexpr int kSphereRounds = 4;

/// Two columns that span the plane orthogonal to n, scaled by `size`; the third column is zero.
Matrix3d tangent_plane(const Vector3d& n, double size) {
  const Vector3d other = std::abs(n.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY();
  Matrix3d B = Matrix3d::Zero();
  B.col(0) = n.cross(other).normalized();
  B.col(1) = n.cross(B.col(0));
  return size * B;
}

std::vector<State> world_states(const VelocityProblem& problem,
                                const VelocityProblem::Solution& solution,
                                const std::vector<RelativeMotion>& visual,
                                const std::vector<ImuMotion>& inertial,
                                const ImuBias& bias) {
  const SO3d R_world_body0 = level(solution.gravity);
  std::vector<State> states;
  Vector3d p = Vector3d::Zero();  // in body 0's frame
  for (std::size_t i = 0; i < solution.velocities.size(); ++i) {
    const SO3d& R = problem.rotations()[i];
    State state;
    const bool last = i == visual.size();
    state.time_ns = last ? visual.back().time1_ns : visual[i].time0_ns;
    state.nav.T_world_body = lie::SE3d(R_world_body0 * R, R_world_body0 * p);
    state.nav.v_world = R_world_body0 * solution.velocities[i];
    state.bias = bias;
    states.push_back(state);
    if (last) break;
    const double dt = to_seconds(visual[i].time1_ns - visual[i].time0_ns);
    p += visual[i].valid     ? Vector3d(R * visual[i].T_body0_body1.translation())
         : inertial[i].valid ? Vector3d(solution.velocities[i] * dt +
                                        0.5 * dt * dt * solution.gravity + R * inertial[i].dp)
                             : Vector3d(solution.velocities[i] * dt);
  }
  return states;
}

std::string insufficient_data(const std::vector<RelativeMotion>& visual,
                              const std::vector<ImuMotion>& inertial,
                              const InitializationOptions& options) {
  int both = 0;
  double duration_s = 0.0;
  for (std::size_t i = 0; i < visual.size(); ++i) {
    if (!visual[i].valid || !inertial[i].valid) continue;
    ++both;
    duration_s += inertial[i].dt_s;
  }
  if (both < options.min_intervals || duration_s < options.min_duration_s) {
    return "only " + std::to_string(both) + " intervals (" + std::to_string(duration_s) +
           " s) have both vision and IMU data";
  }
  return "";
}

}  // namespace

void InitializationOptions::validate() const {
  expects(gravity_magnitude > 0.0 && gravity_tolerance > 0.0 && accel_bias_sigma > 0.0 &&
              max_gravity_sigma_rad > 0.0 && min_intervals >= 2,
          "initialisation: options must be positive, min_intervals at least 2");
}

SO3d level(const Vector3d& gravity_body0) {
  const Vector3d up = -gravity_body0.normalized();
  const bool x_is_steep = std::abs(up.x()) > std::cos(M_PI / 6.0);
  const Vector3d ahead = x_is_steep ? Vector3d::UnitZ() : Vector3d::UnitX();
  Matrix3d R_body0_world;
  R_body0_world.col(2) = up;
  R_body0_world.col(0) = (ahead - up * up.dot(ahead)).normalized();
  R_body0_world.col(1) = up.cross(R_body0_world.col(0));
  return SO3d::from_matrix(R_body0_world).inverse();
}

Initialization initialize(const std::vector<RelativeMotion>& visual,
                          const std::vector<ImuMotion>& inertial,
                          const InitializationOptions& options) {
  options.validate();
  expects(visual.size() == inertial.size(), "initialisation: one motion of each kind per interval");
  Initialization result;
  result.reason = insufficient_data(visual, inertial, options);
  if (!result.reason.empty()) return result;

  result.bias.gyro = fit_gyro_bias(visual, inertial, options.visual_rotation_floor);
  const VelocityProblem problem(visual, inertial, result.bias.gyro, options);
  VelocityProblem::Solution solution;
  if (!problem.solve(Vector3d::Zero(), Matrix3d::Identity(), false, solution)) {
    result.reason = "velocities and gravity are not determined by the data";
    return result;
  }
  const double measured = solution.gravity.norm();
  if (!(std::abs(measured - options.gravity_magnitude) <
        options.gravity_tolerance * options.gravity_magnitude)) {
    result.reason = "measured gravity is " + std::to_string(measured) +
                    " m/s^2; check units and extrinsics of the IMU";
    return result;
  }
  for (int round = 0; round < kSphereRounds; ++round) {
    const Vector3d n = solution.gravity.normalized();
    const double G = options.gravity_magnitude;
    if (!problem.solve(G * n, tangent_plane(n, G), true, solution)) {
      result.reason = "the direction of gravity is not determined by the data";
      return result;
    }
  }
  result.gravity_sigma_rad =
      std::sqrt(solution.parameter_covariance.topLeftCorner<2, 2>().trace() / 2.0);
  if (!(result.gravity_sigma_rad < options.max_gravity_sigma_rad)) {
    result.reason = "the direction of gravity is uncertain by " +
                    std::to_string(result.gravity_sigma_rad) + " rad";
    return result;
  }
  result.gravity_body0 = options.gravity_magnitude * solution.gravity.normalized();
  result.bias.accel = solution.accel_bias;
  result.states = world_states(problem, solution, visual, inertial, result.bias);
  result.success = true;
  return result;
}

}  // namespace imslam::pgo

#include "slam/training/inertial_log.hpp"

#include <algorithm>

#include "imu_net/preintegration.hpp"
#include "slam/base/time.hpp"

namespace imslam::training {
namespace {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// Of dR, dv, dp between two states that are uncertain themselves.
///
///   attitude 0 turned by a:  dR Exp(-dR^T a), dv + [dv]x a, dp + [dp]x a; both turned alike: no dR
///   velocity 0 off by n:     dv - n, dp - n T      velocity 1: dv + n      positions: dp +- n
Matrix9d truth_covariance(const ImuMotion& motion, const TruthSigma& sigma) {
  Eigen::Matrix<double, 9, 3> by_attitude0;
  by_attitude0 << -motion.dR.inverse().matrix(), lie::skew(motion.dv), lie::skew(motion.dp);
  Eigen::Matrix<double, 9, 3> by_tilt = by_attitude0;
  by_tilt.topRows<3>().setZero();
  Eigen::Matrix<double, 9, 3> by_velocity0 = Eigen::Matrix<double, 9, 3>::Zero();
  by_velocity0.middleRows<3>(3).diagonal().setConstant(-1.0);
  by_velocity0.bottomRows<3>().diagonal().setConstant(-motion.dt_s);

  const auto squared = [](double x) { return x * x; };
  Matrix9d covariance = squared(sigma.rotation) * by_attitude0 * by_attitude0.transpose() +
                        squared(sigma.tilt) * by_tilt * by_tilt.transpose() +
                        squared(sigma.velocity) * by_velocity0 * by_velocity0.transpose();
  covariance.diagonal().head<3>().array() += squared(sigma.rotation);
  covariance.diagonal().segment<3>(3).array() += squared(sigma.velocity);
  covariance.diagonal().tail<3>().array() += 2.0 * squared(sigma.position);
  return covariance;
}

}  // namespace

IntegrationWindow true_window(const InertialLog& log, std::size_t first, std::size_t last) {
  const InertialLog::TrueState& a = log.truth.at(first);
  const InertialLog::TrueState& b = log.truth.at(last);
  IntegrationWindow window;
  window.first = first;
  window.last = last;
  window.motion =
      imu::motion_between(a.nav, b.nav, to_seconds(b.time_ns - a.time_ns), log.gravity_world);
  window.motion.time0_ns = a.time_ns;
  window.motion.time1_ns = b.time_ns;
  window.motion.covariance = truth_covariance(window.motion, log.truth_sigma);
  return window;
}

bool jumps_between(const InertialLog& log, std::size_t first, std::size_t last) {
  const auto jump = std::upper_bound(log.truth_jumps.begin(), log.truth_jumps.end(), first);
  return jump != log.truth_jumps.end() && *jump <= last;
}

}  // namespace imslam::training

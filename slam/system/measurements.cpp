#include "slam/system/measurements.hpp"

#include <algorithm>

#include "slam/base/time.hpp"

namespace imslam::system {
namespace {

using Tangent = lie::SE3d::Tangent;

/// Motion per second, in the body frame.
Tangent rate_of(const RelativeMotion& motion) {
  return motion.T_body0_body1.log() / to_seconds(motion.time1_ns - motion.time0_ns);
}

}  // namespace

void Measurements::lend_imu(const ImuSample& kept) {
  if (imu.empty() && (lent_imu.empty() || lent_imu.end() == &kept)) {
    lent_imu = {lent_imu.empty() ? &kept : lent_imu.begin(), &kept + 1};
    return;
  }
  keep_imu(kept);
}

void Measurements::keep_imu(const ImuSample& reading) {
  imu.insert(imu.end(), lent_imu.begin(), lent_imu.end());
  imu.push_back(reading);
  lent_imu = {};
}

std::optional<std::size_t> Measurements::frame_at(std::int64_t time_ns) const {
  const auto found = std::lower_bound(times_ns.begin(), times_ns.end(), time_ns);
  if (found == times_ns.end() || *found != time_ns) return std::nullopt;
  return static_cast<std::size_t>(found - times_ns.begin());
}

OdometryChain chain_odometry(const Measurements& measurements) {
  OdometryChain chain;
  if (measurements.times_ns.empty()) return chain;
  Tangent rate = Tangent::Zero();
  auto motion = measurements.odometry.begin();
  chain.trajectory.add(measurements.times_ns.front(), lie::SE3d());
  chain.covered.push_back(true);
  for (std::size_t i = 1; i < measurements.times_ns.size(); ++i) {
    const std::int64_t time_ns = measurements.times_ns[i];
    const std::int64_t previous_ns = measurements.times_ns[i - 1];
    while (motion != measurements.odometry.end() && motion->time1_ns < time_ns) ++motion;
    const bool covered = motion != measurements.odometry.end() && motion->time0_ns <= previous_ns;
    if (covered) rate = rate_of(*motion);
    // A motion over one interval is taken as it is: Exp(Log(T)) would cost its last digits.
    const bool exact = covered && motion->time0_ns == previous_ns && motion->time1_ns == time_ns;
    const lie::SE3d step =
        exact ? motion->T_body0_body1 : lie::SE3d::exp(rate * to_seconds(time_ns - previous_ns));
    chain.trajectory.add(time_ns, chain.trajectory.poses.back() * step);
    chain.covered.push_back(covered);
  }
  return chain;
}

RelativeMotion bridge(const Trajectory& trajectory, std::size_t to) {
  constexpr double kSigma_m_s = 1.0;
  constexpr double kSigma_rad_s = 0.5;
  RelativeMotion motion;
  motion.time0_ns = trajectory.times_ns[to - 1];
  motion.time1_ns = trajectory.times_ns[to];
  motion.T_body0_body1 = trajectory.poses[to - 1].inverse() * trajectory.poses[to];
  const double dt_s = to_seconds(motion.time1_ns - motion.time0_ns);
  Tangent sigma;
  sigma << Eigen::Vector3d::Constant(kSigma_m_s * dt_s),
      Eigen::Vector3d::Constant(kSigma_rad_s * dt_s);
  motion.covariance = sigma.cwiseAbs2().asDiagonal();
  motion.valid = true;
  return motion;
}

}  // namespace imslam::system

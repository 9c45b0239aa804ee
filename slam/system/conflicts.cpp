#include "slam/system/conflicts.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace imslam::system {
namespace {

constexpr double kSmallest_rad = 0.5 / 57.29577951308232;
constexpr double kSigmas = 8.0;

struct GyroRotation {
  lie::SO3d dR;
  double variance = 0.0;  ///< [rad^2] of all axes together
};

std::optional<GyroRotation> between(const std::vector<ImuMotion>& inertial,
                                    std::size_t from,
                                    std::size_t to) {
  GyroRotation rotation;
  for (std::size_t i = from; i < to; ++i) {
    if (!inertial[i].valid || inertial[i].degraded) return std::nullopt;
    rotation.dR = rotation.dR * inertial[i].dR;
    rotation.variance += inertial[i].covariance.topLeftCorner<3, 3>().trace();
  }
  return rotation;
}

}  // namespace

bool contradicts(const lie::SO3d& gyro, double gyro_variance, const RelativeMotion& vision) {
  const double variance = gyro_variance + vision.covariance.bottomRightCorner<3, 3>().trace();
  const double angle = (gyro.inverse() * vision.T_body0_body1.rotation()).log().norm();
  return angle >= std::max(kSmallest_rad, kSigmas * std::sqrt(variance));
}

std::vector<bool> rotation_conflicts(const Measurements& measurements,
                                     const std::vector<ImuMotion>& inertial) {
  std::vector<bool> conflicts(measurements.times_ns.size(), false);
  for (const RelativeMotion& motion : measurements.odometry) {
    const auto from = measurements.frame_at(motion.time0_ns);
    const auto to = measurements.frame_at(motion.time1_ns);
    if (!from || !to || *to > inertial.size()) continue;
    const auto gyro = between(inertial, *from, *to);
    if (!gyro || !contradicts(gyro->dR, gyro->variance, motion)) continue;
    std::fill(conflicts.begin() + static_cast<std::ptrdiff_t>(*from) + 1,
              conflicts.begin() + static_cast<std::ptrdiff_t>(*to) + 1, true);
  }
  return conflicts;
}

std::optional<Measurements> without_conflicts(const Measurements& measurements,
                                              const std::vector<bool>& conflicts) {
  const auto flagged = std::count(conflicts.begin(), conflicts.end(), true);
  if (flagged == 0 || 2 * static_cast<std::size_t>(flagged) >= conflicts.size()) {
    return std::nullopt;
  }
  const auto contradicted = [&](const RelativeMotion& motion) {
    const auto from = measurements.frame_at(motion.time0_ns);
    const auto to = measurements.frame_at(motion.time1_ns);
    return (from && conflicts[*from]) || (to && conflicts[*to]);
  };
  Measurements kept = measurements;
  for (auto* motions : {&kept.odometry, &kept.skips}) {
    motions->erase(std::remove_if(motions->begin(), motions->end(), contradicted), motions->end());
  }
  return kept;
}

}  // namespace imslam::system

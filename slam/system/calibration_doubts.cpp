#include "slam/system/calibration_doubts.hpp"

#include <algorithm>

#include "datasets/judge_calibration.hpp"

namespace imslam::system {
namespace {

constexpr std::size_t kMostMotions = 1200;

datasets::VisualRotation in_camera(const RelativeMotion& motion, const lie::SE3d& T_body_left) {
  const lie::SE3d T_left0_left1 = T_body_left.inverse() * motion.T_body0_body1 * T_body_left;
  return {motion.time0_ns, motion.time1_ns, T_left0_left1.rotation().log(),
          T_left0_left1.translation()};
}

}  // namespace

std::vector<std::string> calibration_doubts(const Measurements& measurements,
                                            const StereoCamera& camera) {
  const lie::SE3d& T_body_left = camera.T_body_left;
  std::vector<datasets::VisualRotation> vision;
  for (std::size_t i = 0; i < std::min(kMostMotions, measurements.odometry.size()); ++i) {
    vision.push_back(in_camera(measurements.odometry[i], T_body_left));
  }
  const imu::ImuRange readings = measurements.readings();
  const std::vector<ImuSample> imu(readings.begin(), readings.end());
  const auto rotations = datasets::compare_rotations(vision, imu, T_body_left.rotation());
  if (!rotations.valid) return {};
  datasets::Findings findings;
  datasets::judge_rotations(rotations, T_body_left.rotation(), findings);
  datasets::judge_scale(datasets::compare_scale(vision, imu, T_body_left, rotations.time_offset_s),
                        findings);
  std::vector<std::string> doubts;
  for (const datasets::Finding& finding : findings.all()) {
    if (finding.severity == datasets::Severity::kInfo) continue;
    doubts.push_back("calibration: " + finding.what + "; " + finding.remedy);
  }
  return doubts;
}

}  // namespace imslam::system

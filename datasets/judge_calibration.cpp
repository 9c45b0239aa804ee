#include "datasets/judge_calibration.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imslam::datasets {
namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr double kSameMotion = 0.8;  ///< correlation: vision and gyro saw the same
/// A wrong focal length shows in part only, and either way: rotation passes for translation.
constexpr double kFocalTolerance = 0.05;
constexpr double kScaleTolerance = 0.25;  ///< accelerometers and coarse odometry err, too
constexpr double kScaleSigmas = 4.0;

double extrinsic_error_deg(const RotationComparison& fit, const lie::SO3d& R_body_left) {
  return (R_body_left * fit.R_left_body).log().norm() * kDegrees;
}

void report_fit(const RotationComparison& fit, const lie::SO3d& R_body_left, Findings& findings) {
  std::string text = fmt::format(
      "vision against gyro over {} intervals: correlation {:.3f}, scale {:.3f}, time offset "
      "{:+.1f} ms (t_imu = t_camera + offset)",
      fit.intervals, fit.correlation, fit.scale, fit.time_offset_s * 1e3);
  if (fit.planarity > 0.15) {
    text += fmt::format(", extrinsic rotation off by {:.2f} deg",
                        extrinsic_error_deg(fit, R_body_left));
  }
  findings.info(text);
}

void judge_extrinsics(const RotationComparison& fit,
                      const lie::SO3d& R_body_left,
                      Findings& findings) {
  if (fit.correlation < kSameMotion) return;
  const double lost = fit.correlation - fit.calibrated;
  if (lost > 0.2 && fit.inverted > fit.calibrated + 0.2) {
    findings.fail(ExitCode::kCalibration,
                  fmt::format("the camera-IMU rotation looks inverted: gyro and vision agree to "
                              "{:.2f} with its inverse, to {:.2f} as given",
                              fit.inverted, fit.calibrated),
                  "give the inverse of the extrinsics (EuRoC T_BS: sensor to body; Kalibr "
                  "T_cam_imu: IMU to camera)");
  } else if (lost > 0.2) {
    findings.fail(
        ExitCode::kCalibration,
        fmt::format("the camera-IMU rotation does not fit: gyro and vision agree to {:.2f} "
                    "with it, to {:.2f} with the best one",
                    fit.calibrated, fit.correlation),
        "check the axes of IMU and camera in the extrinsics");
  } else if (fit.correlation > 0.9 && fit.planarity > 0.15 && lost > 0.005) {
    findings.warn(fmt::format("the camera-IMU rotation is off by {:.1f} deg",
                              extrinsic_error_deg(fit, R_body_left)),
                  "calibrate the extrinsics again");
  }
}

void judge_focal_length(const RotationComparison& fit, Findings& findings) {
  if (fit.scale < 0.1) {
    findings.fail(
        ExitCode::kData,
        fmt::format("the gyro turns {:.1f} times faster than the images", 1.0 / fit.scale),
        std::abs(fit.scale * kDegrees - 1.0) < 0.3
            ? "it is in degrees per second; convert it to radians"
            : "check the gyro's unit");
  } else if (fit.correlation > kSameMotion && std::abs(fit.scale - 1.0) > kFocalTolerance) {
    findings.warn(fmt::format("the images turn {:.2f} times as fast as the gyro", fit.scale),
                  "the focal length seems to be wrong, or the gyro's scale: calibrate again");
  }
}

}  // namespace

void judge_rotations(const RotationComparison& fit,
                     const lie::SO3d& R_body_left,
                     Findings& findings) {
  if (!fit.valid) return;
  report_fit(fit, R_body_left, findings);
  judge_extrinsics(fit, R_body_left, findings);
  judge_focal_length(fit, findings);
}

void judge_clock(const RotationComparison& fit, Findings& findings) {
  if (!fit.valid || fit.correlation <= kSameMotion || std::abs(fit.time_offset_s) <= 5e-3) return;
  findings.warn(fmt::format("camera and IMU clocks differ by {:+.1f} ms", fit.time_offset_s * 1e3),
                "the run estimates it; correct the stamps for best results");
}

void judge_scale(const ScaleComparison& fit, Findings& findings) {
  if (!fit.valid) return;
  findings.info(
      fmt::format("vision against accelerometer over {} moments: scale {:.2f} +- {:.2f}, gravity "
                  "{:.2f} m/s^2",
                  fit.moments, fit.scale, fit.sigma, fit.gravity));
  const double error = std::abs(std::log(fit.scale));
  const double sigma = fit.sigma / fit.scale;
  if (error < std::log(1.0 + kScaleTolerance) || error < kScaleSigmas * sigma) return;
  findings.warn(
      fmt::format("the images move {:.2f} times as far as the accelerometer says", fit.scale),
      fmt::format("the baseline seems to be wrong by a factor of about {:.2f} (unit, or another "
                  "rig's calibration?), or the accelerometer's unit is",
                  fit.scale));
}

}  // namespace imslam::datasets

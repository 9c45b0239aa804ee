#include "slam/adaptation/device_refinement.hpp"

#include <cmath>

namespace imslam::adaptation {
namespace {

/// A number is known better than before if its variance is less than a quarter of the prior's.
constexpr double kKnown = 0.5;
/// Changes of fewer standard deviations are hardly there: most devices are as their makers say.
constexpr double kSurely = 2.0;

bool keeps_calibration(const AdaptationOptions& options, const system::SlamOptions& slam) {
  if (options.calibration == "auto") return slam.vo.head == "geometric";
  return options.calibration == "on";
}

bool is_news(double change, const std::optional<double>& sigma, double prior) {
  return sigma && *sigma < kKnown * prior && std::abs(change) > kSurely * *sigma;
}

void take_focal_length(const system::SlamResult& result,
                       const system::SystemOptions& priors,
                       DeviceCalibration& device) {
  const auto& focal = result.focal_error;
  if (!focal || !is_news(focal->value, focal->sigma, priors.focal_error_prior)) return;
  device.focal_error = (1.0 + device.focal_error) * (1.0 + focal->value) - 1.0;
}

void take_disparity_offset(const system::SlamResult& result,
                           const vo::DisparityOffsetOptions& prior,
                           DeviceCalibration& device) {
  const auto& disparity = result.disparity_offset_px;
  const double change = disparity.value - device.disparity_offset_px;
  if (is_news(change, disparity.sigma, prior.prior_sigma)) {
    device.disparity_offset_px = disparity.value;
  }
}

void take_time_offset(const system::SlamResult& result,
                      const system::SystemOptions& priors,
                      DeviceCalibration& device) {
  const auto& offset = result.time_offset_s;
  if (!offset) return;
  const double change = offset->value - device.time_offset_s;
  if (is_news(change, offset->sigma, priors.time_offset_prior_s)) {
    device.time_offset_s = offset->value;
  }
}

void take_rotation(const system::SlamResult& result,
                   const system::SystemOptions& priors,
                   DeviceCalibration& device) {
  const auto& turned = result.camera_rotation;
  for (int axis = 0; turned && turned->sigma && axis < 3; ++axis) {
    // Small angles: the order of turns does not matter to what is left over.
    if (is_news(turned->value[axis], (*turned->sigma)[axis], priors.camera_rotation_prior)) {
      device.camera_rotation[axis] += turned->value[axis];
    }
  }
}

}  // namespace

DeviceCalibration refined_device(const system::SlamResult& result,
                                 const DeviceCalibration& assumed,
                                 const std::optional<ImuNoise>& imu,
                                 const system::SlamOptions& slam,
                                 const AdaptationOptions& options) {
  DeviceCalibration refined = assumed;
  const system::SystemOptions& priors = slam.system;
  if (!result.solve.converged || !keeps_calibration(options, slam)) return refined;
  take_time_offset(result, priors, refined);
  take_disparity_offset(result, slam.vo.offset, refined);
  if (imu && imu->gyro_bias_sigma <= priors.trusted_gyro_bias) {
    take_focal_length(result, priors, refined);
    if (options.camera_rotation) take_rotation(result, priors, refined);
  }
  return within_bounds(refined);
}

}  // namespace imslam::adaptation

#include "slam/adaptation/device_refinement.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "slam/system/slam_lower_problem.hpp"

namespace imslam::adaptation {
namespace {

using Vector = learner::Vector;

constexpr double kRotationPrior = 0.01;  // [rad] of a camera screwed to its IMU
constexpr double kAside = 1e-3;          // [rad] where the slope is taken once more
constexpr double kQuotient = 1e-6;       // [rad] of difference quotients
/// A number is known better than before if its variance is less than a quarter of the prior's.
constexpr double kKnown = 0.5;

/// The graph of a run as a function of how the camera is turned.
class TurnedCamera {
 public:
  TurnedCamera(const system::SlamResult& result, const lie::SE3d& T_body_left)
      : data_(result.graph_data),
        T_body_left_(T_body_left),
        problem_(result.graph_data, result.graph_options) {}

  /// dU/ddelta without the prior; empty: not converged.
  std::optional<Eigen::Vector3d> slope(const Eigen::Vector3d& delta) {
    if (!problem_.solve(measurements(delta)).converged) return std::nullopt;
    const Vector by_z = problem_.cost_by_z();
    Eigen::Vector3d slope;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = kQuotient * Eigen::Vector3d::Unit(axis);
      slope[axis] =
          by_z.dot(measurements(delta + step) - measurements(delta - step)) / (2.0 * kQuotient);
    }
    return slope;
  }

 private:
  Vector measurements(const Eigen::Vector3d& delta) const {
    const auto& coordinates = problem_.coordinates();
    Vector z = coordinates.origin();
    const lie::SE3d turn = T_body_left_ *
                           lie::SE3d(lie::SO3d::exp(delta), Eigen::Vector3d::Zero()) *
                           T_body_left_.inverse();
    for (std::size_t e = 0; e < data_.visual_edges.size(); ++e) {
      RelativeMotion motion = data_.visual_edges[e].motion;
      motion.T_body0_body1 = turn * motion.T_body0_body1 * turn.inverse();
      z.segment(coordinates.visual(e), 6) = coordinates.visual_numbers(e, motion).head<6>();
    }
    return z;
  }

  const pgo::GraphData& data_;
  lie::SE3d T_body_left_;
  system::SlamLowerProblem problem_;
};

bool keeps_calibration(const AdaptationOptions& options, const system::SlamOptions& slam) {
  if (options.calibration == "auto") return slam.vo.head == "geometric";
  return options.calibration == "on";
}

bool is_known(const std::optional<double>& sigma, double prior) {
  return sigma && *sigma < kKnown * prior;
}

void take_focal_length(const system::SlamResult& result,
                       const system::SystemOptions& priors,
                       DeviceCalibration& device) {
  const auto& focal = result.focal_error;
  if (!focal || !is_known(focal->sigma, priors.focal_error_prior)) return;
  device.focal_error = (1.0 + device.focal_error) * (1.0 + focal->value) - 1.0;
}

void take_disparity_offset(const system::SlamResult& result,
                           const system::SystemOptions& priors,
                           DeviceCalibration& device) {
  const auto& disparity = result.disparity_offset_px;
  if (is_known(disparity.sigma, priors.disparity_offset_prior_px)) {
    device.disparity_offset_px = disparity.value;
  }
}

void take_time_offset(const system::SlamResult& result,
                      const system::SystemOptions& priors,
                      DeviceCalibration& device) {
  const auto& offset = result.time_offset_s;
  if (offset && is_known(offset->sigma, priors.time_offset_prior_s)) {
    device.time_offset_s = offset->value;
  }
}

void take_rotation(const system::SlamResult& result,
                   const StereoCamera& assumed,
                   DeviceCalibration& device) {
  const auto turned = camera_rotation(result, assumed.T_body_left, kRotationPrior);
  for (int axis = 0; turned && axis < 3; ++axis) {
    // Small angles: the order of turns does not matter to what is left over.
    if (!is_known(turned->sigma[axis], kRotationPrior)) continue;
    device.camera_rotation[axis] += turned->rotation[axis];
  }
}

}  // namespace

std::optional<CameraRotation> camera_rotation(const system::SlamResult& result,
                                              const lie::SE3d& T_body_left,
                                              double prior_sigma) {
  if (!result.inertial || !result.solve.converged) return std::nullopt;
  if (result.graph_data.inertial_edges.empty()) return std::nullopt;  // the published windows
  TurnedCamera graph(result, T_body_left);
  const auto here = graph.slope(Eigen::Vector3d::Zero());
  if (!here) return std::nullopt;
  Eigen::Matrix3d H;
  for (int axis = 0; axis < 3; ++axis) {
    const auto aside = graph.slope(kAside * Eigen::Vector3d::Unit(axis));
    if (!aside) return std::nullopt;
    H.col(axis) = (*aside - *here) / kAside;
  }
  H = (0.5 * (H + H.transpose())).eval();
  H.diagonal().array() += 1.0 / (prior_sigma * prior_sigma);
  const Eigen::LLT<Eigen::Matrix3d> factor(H);
  if (factor.info() != Eigen::Success) return std::nullopt;
  CameraRotation found;
  found.rotation = -factor.solve(*here);
  found.sigma = factor.solve(Eigen::Matrix3d::Identity()).diagonal().cwiseSqrt();
  return found;
}

DeviceCalibration refined_device(const system::SlamResult& result,
                                 const DeviceCalibration& assumed,
                                 const StereoCamera& stated,
                                 const std::optional<ImuNoise>& imu,
                                 const system::SlamOptions& slam,
                                 const AdaptationOptions& options) {
  DeviceCalibration refined = assumed;
  const system::SystemOptions& priors = slam.system;
  if (!result.solve.converged || !keeps_calibration(options, slam)) return refined;
  take_time_offset(result, priors, refined);
  take_disparity_offset(result, priors, refined);
  if (imu && imu->gyro_bias_sigma <= options.trusted_gyro_bias) {
    take_focal_length(result, priors, refined);
    if (options.camera_rotation) take_rotation(result, calibrated(stated, assumed), refined);
  }
  return within_bounds(refined);
}

}  // namespace imslam::adaptation

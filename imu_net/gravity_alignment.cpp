#include "imu_net/gravity_alignment.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {

lie::SO3d upright_rotation(const Eigen::Vector3d& force_body) {
  expects(force_body.allFinite() && force_body.norm() > 0.0,
          "upright_rotation: force_body must not be zero");
  return lie::SO3d(
      Eigen::Quaterniond::FromTwoVectors(force_body.normalized(), Eigen::Vector3d::UnitZ()));
}

std::optional<GravityAlignment> align_to_gravity(ImuRange samples,
                                                 std::int64_t time0_ns,
                                                 const ImuNoise& noise,
                                                 const StaticDetectorOptions& options,
                                                 double window_s,
                                                 double accel_bias_std) {
  const Stillness rest =
      assess_stillness(samples, time0_ns, time0_ns + to_nanoseconds(window_s), noise, options);
  if (!rest.still) return std::nullopt;

  // The bins' scatter holds noise and what little the body still sways; neither may claim to be
  // better than the datasheet.
  const auto mean_variance = [&](const Eigen::Vector3d& spread, double density) {
    const Eigen::Vector3d measured = spread.cwiseAbs2() / rest.bins;
    return measured.cwiseMax(density * density / window_s).eval();
  };
  GravityAlignment result;
  result.R_world_body = upright_rotation(rest.mean_force);
  result.bias.gyro = rest.mean_rate;
  result.gyro_bias_covariance =
      mean_variance(rest.rate_spread, noise.gyro_noise_density).asDiagonal();
  const double force_variance =
      mean_variance(rest.force_spread, noise.accel_noise_density).maxCoeff();
  result.tilt_std =
      std::sqrt(force_variance + accel_bias_std * accel_bias_std) / rest.mean_force.norm();
  return result;
}

}  // namespace imslam::imu

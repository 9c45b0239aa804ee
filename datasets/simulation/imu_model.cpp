#include "datasets/simulation/imu_model.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/time.hpp"

namespace imslam::simulation {
namespace {

/// Typical values of datasheets: white noise, bias walk, turn-on bias, scale, misalignment, range.
struct Grade {
  ImuNoise noise;
  double gyro_bias;     ///< sigma [rad/s]
  double accel_bias;    ///< sigma [m/s^2]
  double scale;         ///< sigma of the scale factor error
  double misalignment;  ///< sigma [rad]
};

ImuNoise densities(double gyro, double gyro_walk, double accel, double accel_walk) {
  ImuNoise noise;
  noise.gyro_noise_density = gyro;
  noise.gyro_random_walk = gyro_walk;
  noise.accel_noise_density = accel;
  noise.accel_random_walk = accel_walk;
  return noise;
}

Grade grade_named(const std::string& name) {
  Grade grade;
  if (name == "tactical") {
    grade = {densities(3.5e-5, 1e-6, 4e-4, 5e-5), 2e-4, 0.01, 2e-4, 2e-4};
  } else if (name == "mems") {
    grade = {densities(3e-4, 4e-5, 3e-3, 2e-3), 0.01, 0.15, 3e-3, 2e-3};
  } else if (name == "phone") {
    grade = {densities(8e-4, 1e-4, 8e-3, 4e-3), 0.03, 0.3, 8e-3, 5e-3};
  } else {  // industrial, and what a perfect sensor claims to be
    grade = {densities(1.7e-4, 1.9e-5, 2e-3, 3e-3), 0.02, 0.08, 5e-4, 5e-4};
  }
  const bool small_range = name == "mems" || name == "phone";
  grade.noise.gyro_range = small_range ? 17.45 : 34.9;
  grade.noise.accel_range = small_range ? 78.5 : 157.0;
  return grade;
}

Eigen::Matrix3d shape_error(double scale, double misalignment, Random& random) {
  Eigen::Matrix3d shape = Eigen::Matrix3d::Identity();
  shape.diagonal() += scale * random.normal3();
  const Eigen::Vector3d lower = misalignment * random.normal3();
  const Eigen::Vector3d upper = misalignment * random.normal3();
  shape(1, 0) = lower[0];
  shape(2, 0) = lower[1];
  shape(2, 1) = lower[2];
  shape(0, 1) = upper[0];
  shape(0, 2) = upper[1];
  shape(1, 2) = upper[2];
  return shape;
}

Eigen::Vector3d digitise(const Eigen::Vector3d& value, double range, double step) {
  Eigen::Vector3d result = value.cwiseMax(-range).cwiseMin(range);
  if (step > 0.0) result = (result / step).array().round() * step;
  return result;
}

}  // namespace

Eigen::Vector3d specific_force(const MotionState& state) {
  return state.T_world_body.rotation().inverse() *
         (state.a_world + Eigen::Vector3d(0.0, 0.0, kGravity));
}

ImuErrors draw_imu_errors(const ImuOptions& options, Random random) {
  const Grade grade = grade_named(options.grade);
  const double perfect = options.grade == "perfect" ? 0.0 : 1.0;
  ImuErrors errors;
  errors.noise = grade.noise;
  errors.noise.rate_hz = options.rate_hz;
  if (options.gyro_range > 0.0) errors.noise.gyro_range = options.gyro_range;
  if (options.accel_range > 0.0) errors.noise.accel_range = options.accel_range;
  errors.data_sheet = errors.noise;
  const double noise_scale = perfect * options.noise_scale;
  for (double ImuNoise::*density : {&ImuNoise::gyro_noise_density, &ImuNoise::gyro_random_walk,
                                    &ImuNoise::accel_noise_density, &ImuNoise::accel_random_walk}) {
    errors.noise.*density *= noise_scale;
    // An estimator divides by these: a perfect sensor admits to a hundredth of the usual noise.
    errors.data_sheet.*density *= std::max(noise_scale, 0.01);
  }
  errors.initial_bias.gyro = perfect * options.bias_scale * grade.gyro_bias * random.normal3();
  errors.initial_bias.accel = perfect * options.bias_scale * grade.accel_bias * random.normal3();
  const double shape = perfect * options.shape_scale;
  errors.gyro_shape = shape_error(shape * grade.scale, shape * grade.misalignment, random);
  errors.accel_shape = shape_error(shape * grade.scale, shape * grade.misalignment, random);
  if (options.quantise) {
    errors.gyro_step = errors.noise.gyro_range / 32768.0;
    errors.accel_step = errors.noise.accel_range / 32768.0;
  }
  return errors;
}

ImuModel::ImuModel(const ImuErrors& errors,
                   const MotionSpline& motion,
                   std::int64_t start_ns,
                   const Random& random)
    : errors_(errors),
      motion_(&motion),
      start_ns_(start_ns),
      random_(random),
      bias_(errors.initial_bias) {}

SimulatedImuSample ImuModel::next() {
  const ImuNoise& noise = errors_.noise;
  const double rate = noise.rate_hz;
  if (count_ > 0) {  // the walk of one period
    const double root_dt = 1.0 / std::sqrt(rate);
    bias_.gyro += noise.gyro_random_walk * root_dt * random_.normal3();
    bias_.accel += noise.accel_random_walk * root_dt * random_.normal3();
  }
  const std::int64_t offset_ns = to_nanoseconds(static_cast<double>(count_++) / rate);

  SimulatedImuSample sample;
  sample.time_s = to_seconds(offset_ns);
  sample.truth = motion_->at(sample.time_s);
  sample.bias = bias_;
  sample.reading.time_ns = start_ns_ + offset_ns;
  const double root_rate = std::sqrt(rate);
  const Eigen::Vector3d gyro = errors_.gyro_shape * sample.truth.omega_body + bias_.gyro +
                               noise.gyro_noise_density * root_rate * random_.normal3();
  const Eigen::Vector3d accel = errors_.accel_shape * specific_force(sample.truth) + bias_.accel +
                                noise.accel_noise_density * root_rate * random_.normal3();
  sample.reading.angular_velocity = digitise(gyro, noise.gyro_range, errors_.gyro_step);
  sample.reading.linear_acceleration = digitise(accel, noise.accel_range, errors_.accel_step);
  return sample;
}

}  // namespace imslam::simulation

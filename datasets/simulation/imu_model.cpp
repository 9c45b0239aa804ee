#include "datasets/simulation/imu_model.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/time.hpp"

namespace imslam::simulation {
namespace {

/// Typical values of datasheets: white noise, bias walk, turn-on bias, scale, misalignment, range,
/// g-sensitivity (0.003, 0.015, 0.1, 0.2 deg/s/g), change of bias by some 10 K of self-heating.
/// Sources: ADIS16488 (tactical), ADIS16448 (industrial), BMI160 (mems), phones a class below it.
struct Grade {
  ImuNoise noise;
  double gyro_bias;            ///< sigma [rad/s]
  double accel_bias;           ///< sigma [m/s^2]
  double scale;                ///< sigma of the scale factor error
  double misalignment;         ///< sigma [rad]
  double g_sensitivity = 0.0;  ///< sigma [rad/s per m/s^2]
  double gyro_drift = 0.0;     ///< sigma [rad/s]
  double accel_drift = 0.0;    ///< sigma [m/s^2]
};

/// Streams of their own: what they decide came later than the rest.
enum : std::uint64_t { kGSensitivityStream = 0x65, kDriftStream = 0x74, kVibrationStream = 0x76 };

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
    grade = {densities(3.5e-5, 1e-6, 4e-4, 5e-5), 2e-4, 0.01, 2e-4, 2e-4, 5.3e-6, 2e-4, 0.005};
  } else if (name == "mems") {
    grade = {densities(3e-4, 4e-5, 3e-3, 2e-3), 0.01, 0.15, 3e-3, 2e-3, 1.8e-4, 0.01, 0.1};
  } else if (name == "phone") {
    grade = {densities(8e-4, 1e-4, 8e-3, 4e-3), 0.03, 0.3, 8e-3, 5e-3, 3.6e-4, 0.02, 0.15};
  } else {  // industrial, and what a perfect sensor claims to be
    grade = {densities(1.7e-4, 1.9e-5, 2e-3, 3e-3), 0.02, 0.08, 5e-4, 5e-4, 2.7e-5, 0.005, 0.02};
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

void draw_drift(ImuErrors& errors, const Grade& grade, double scale, Random random) {
  errors.drift.gyro = scale * grade.gyro_drift * random.normal3();
  errors.drift.accel = scale * grade.accel_drift * random.normal3();
  constexpr double kShortest_s = 30.0;
  constexpr double kLongest_s = 300.0;
  errors.drift_time_s = kShortest_s * std::pow(kLongest_s / kShortest_s, random.uniform());
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
  Random per_force = random.fork(kGSensitivityStream);
  for (int column = 0; column < 3; ++column) {
    errors.g_sensitivity.col(column) =
        perfect * options.g_sensitivity_scale * grade.g_sensitivity * per_force.normal3();
  }
  draw_drift(errors, grade, perfect * options.temperature_scale, random.fork(kDriftStream));
  errors.vibration = perfect * options.vibration;
  if (options.quantise) {
    errors.gyro_step = errors.noise.gyro_range / 32768.0;
    errors.accel_step = errors.noise.accel_range / 32768.0;
  }
  return errors;
}

ImuModel::ImuModel(const ImuErrors& errors,
                   const MotionSpline& motion,
                   std::int64_t start_ns,
                   const Random& random,
                   const std::vector<VibrationLevel>& levels)
    : errors_(errors),
      motion_(&motion),
      start_ns_(start_ns),
      random_(random),
      bias_(errors.initial_bias),
      feels_force_(!errors.g_sensitivity.isZero(0.0)),
      drifts_(!errors.drift.gyro.isZero(0.0) || !errors.drift.accel.isZero(0.0)) {
  if (errors.vibration > 0.0 && !levels.empty()) {
    vibration_.emplace(errors.vibration, errors.noise.rate_hz, levels,
                       random.fork(kVibrationStream));
  }
}

ImuBias ImuModel::drift_at(double time_s) const {
  const double share = 1.0 - std::exp(-time_s / errors_.drift_time_s);
  return {share * errors_.drift.gyro, share * errors_.drift.accel};
}

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
  if (drifts_) {
    const ImuBias drift = drift_at(sample.time_s);
    sample.bias.gyro += drift.gyro;
    sample.bias.accel += drift.accel;
  }
  sample.reading.time_ns = start_ns_ + offset_ns;
  const double root_rate = std::sqrt(rate);
  const Eigen::Vector3d force = specific_force(sample.truth);
  Eigen::Vector3d gyro = errors_.gyro_shape * sample.truth.omega_body + sample.bias.gyro +
                         noise.gyro_noise_density * root_rate * random_.normal3();
  Eigen::Vector3d accel = errors_.accel_shape * force + sample.bias.accel +
                          noise.accel_noise_density * root_rate * random_.normal3();
  if (feels_force_) gyro += errors_.g_sensitivity * force;
  if (vibration_) {
    const Vibration::Reading vibration = vibration_->next(sample.time_s);
    gyro += vibration.gyro;
    accel += vibration.accel;
  }
  sample.reading.angular_velocity = digitise(gyro, noise.gyro_range, errors_.gyro_step);
  sample.reading.linear_acceleration = digitise(accel, noise.accel_range, errors_.accel_step);
  return sample;
}

}  // namespace imslam::simulation

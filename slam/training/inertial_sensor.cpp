#include "slam/training/inertial_sensor.hpp"

#include <array>
#include <cmath>

#include "slam/training/motion_tracks.hpp"

namespace imslam::training {
namespace {

using Eigen::Vector3d;

double draw_rate_hz(Random& random) {
  struct Choice {
    double rate_hz;
    double up_to;  ///< sum of the shares so far
  };
  constexpr std::array<Choice, 5> kChoices{
      {{50.0, 0.06}, {100.0, 0.41}, {200.0, 0.76}, {400.0, 0.86}, {500.0, 0.93}}};
  const double chance = random.uniform();
  for (const Choice& choice : kChoices) {
    if (chance < choice.up_to) return choice.rate_hz;
  }
  return 1000.0;
}

simulation::ImuOptions draw_grade(const InertialLogOptions& options, Random& random) {
  constexpr std::array<const char*, 4> kGrades{"tactical", "industrial", "mems", "phone"};
  simulation::ImuOptions grade;
  grade.grade = kGrades[static_cast<std::size_t>(random.integer(0, 3))];
  const double drawn_hz = draw_rate_hz(random);
  grade.rate_hz = options.rate_hz > 0.0 ? options.rate_hz : drawn_hz;
  grade.noise_scale = options.noise_scale;
  grade.shape_scale = options.shape_scale * log_uniform(random, 1.0 / 3.0, 3.0);
  grade.g_sensitivity_scale = options.g_sensitivity_scale * log_uniform(random, 1.0 / 3.0, 3.0);
  grade.temperature_scale = options.temperature_scale * log_uniform(random, 1.0 / 3.0, 3.0);
  grade.quantise = random.chance(options.quantised_share);
  return grade;
}

Vector3d direction(Random& random) { return random.normal3().normalized(); }

}  // namespace

simulation::ImuErrors draw_sensor(const InertialLogOptions& options,
                                  double vibration_rms,
                                  Random random) {
  const simulation::ImuOptions grade = draw_grade(options, random);
  simulation::ImuErrors errors = simulation::draw_imu_errors(grade, random.fork(0));
  for (double ImuNoise::*density : {&ImuNoise::gyro_noise_density, &ImuNoise::gyro_random_walk,
                                    &ImuNoise::accel_noise_density, &ImuNoise::accel_random_walk}) {
    const double individual = log_uniform(random, 1.0 / 3.0, 3.0);
    errors.noise.*density *= individual;
    errors.data_sheet.*density *= individual * log_uniform(random, 0.5, 2.0);
  }
  errors.initial_bias.gyro =
      options.bias_scale * log_uniform(random, 1e-4, 0.15) * direction(random);
  errors.initial_bias.accel =
      options.bias_scale * log_uniform(random, 1e-3, 0.5) * direction(random);
  errors.vibration = options.vibration_scale * vibration_rms;
  return errors;
}

lie::SO3d draw_mounting(Random& random) {
  if (random.chance(0.5)) {  // uniform over SO(3)
    const double w = random.normal();
    const Vector3d xyz = random.normal3();
    return lie::SO3d(Eigen::Quaterniond(w, xyz.x(), xyz.y(), xyz.z()));
  }
  // One of the 24 ways to lay the axes on each other: six faces, four turns.
  const auto quarters = [](std::int64_t count) { return 0.5 * M_PI * static_cast<double>(count); };
  const std::int64_t face = random.integer(0, 5);
  const lie::SO3d z_to = face < 4 ? lie::SO3d::exp(quarters(face) * Vector3d::UnitX())
                                  : lie::SO3d::exp(quarters(2 * face - 9) * Vector3d::UnitY());
  const lie::SO3d spin = lie::SO3d::exp(quarters(random.integer(0, 3)) * Vector3d::UnitZ());
  return z_to * spin * lie::SO3d::exp(0.03 * random.normal3());
}

}  // namespace imslam::training

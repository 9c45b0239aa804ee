#include "slam/training/motion_tracks.hpp"

namespace imslam::training {
namespace {

/// Standard deviation of white noise after smoothed().
double remaining_sigma(double width_s) {
  ScalarTrack pulse(6 * box_half_width(width_s) + 3, 0.0);
  pulse[pulse.size() / 2] = 1.0;
  double energy = 0.0;
  for (const double weight : smoothed(pulse, width_s)) energy += weight * weight;
  return std::sqrt(energy);
}

}  // namespace

ScalarTrack smooth_noise(Random& random, std::size_t count, double sigma, double width_s) {
  const double scale = sigma / remaining_sigma(width_s);
  ScalarTrack white(count);
  for (double& value : white) value = scale * random.normal();
  return smoothed(std::move(white), width_s);
}

VectorTrack smooth_noise3(Random& random, std::size_t count, double sigma, double width_s) {
  const double scale = sigma / remaining_sigma(width_s);
  VectorTrack white(count);
  for (Eigen::Vector3d& value : white) value = scale * random.normal3();
  return smoothed(std::move(white), width_s);
}

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

}  // namespace imslam::training

#pragma once

#include <cstdint>
#include <vector>

#include "datasets/simulation/lens.hpp"
#include "datasets/simulation/options.hpp"
#include "slam/sensors/stereo.hpp"

namespace imslam::simulation {

/// Turns radiance into 8-bit pixels.
///
///   grey = round(255 gain (1 - vignetting r^2) radiance + n),  n ~ N(0, read^2 + shot grey)
class ImageSensor {
 public:
  ImageSensor(const ImageOptions& options, const Lens& lens);

  /// `noise_seed` decides the noise: give each image of a sequence its own.
  GrayImage expose(const std::vector<float>& radiance, double gain, std::uint64_t noise_seed) const;

 private:
  int width_;
  int height_;
  double read_variance_;
  double shot_;
  std::vector<float> vignette_;  ///< factor of each pixel
  std::vector<float> sigmas_;    ///< of the noise, for each grey level
};

}  // namespace imslam::simulation

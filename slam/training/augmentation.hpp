#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/training/degradation.hpp"
#include "slam/training/occluders.hpp"
#include "slam/training/triplet.hpp"

namespace imslam {
class Config;
}

namespace imslam::training {

/// How often (share of the triplets) and how strong at most, when the ramp is 1.
struct AugmentationOptions {
  int seed = 1;
  double exposure_share = 0.4;  ///< the gain jumps between t-1 and t
  double least_gain = 0.3;
  double most_gain = 3.0;
  double gamma_share = 0.5;
  double most_gamma = 1.8;  ///< and its inverse the least
  double dark_share = 0.2;
  double darkest = 0.04;  ///< share of the light that is left
  double vignetting_share = 0.4;
  double vignetting = 0.7;
  double haze_share = 0.15;
  double haze = 0.85;
  double motion_blur_share = 0.3;
  double motion_blur = 24.0;  ///< [px]
  double defocus_share = 0.3;
  double defocus = 3.0;  ///< sigma [px]
  double noise_share = 0.7;
  double read_noise = 25.0;  ///< sigma [grey levels]
  double shot_noise = 0.3;   ///< variance per grey level [grey levels]
  double hot_pixel_share = 0.3;
  int hot_pixels = 60;
  double occluder_share = 0.3;
  int occluders = 4;
  double occluder_flow = 30.0;       ///< [px] sigma, per axis
  double occluder_disparity = 60.0;  ///< [px] most

  void describe(Config& config);
  void validate() const;
};

/// What happens to one triplet.
struct TripletDegradation {
  ViewDegradation left0, right0, left1;
  std::array<std::uint64_t, 3> noise_seeds{};  ///< of left0, right0, left1
  std::vector<Occluder> occluders;
};

/// Draws and applies degradations. left0 and right0 are taken at one instant, left0 and left1 with
/// one camera: each shares what goes with it; each effect has a random strength of its own.
///
/// Depends on the options, the index and the ramp only.
class Augmentation {
 public:
  /// Throws InputError(kUsage) on bad options.
  explicit Augmentation(const AugmentationOptions& options);

  /// `ramp` in [0, 1] scales all strengths; 0: nothing is changed.
  TripletDegradation draw(std::uint64_t index, double ramp, int width, int height) const;

  /// Degrades sample `index`; its truth stays exact.
  void apply(std::uint64_t index, double ramp, Triplet& triplet) const;

 private:
  AugmentationOptions options_;
};

/// Occluders first, then each view.
void degrade(const TripletDegradation& degradation, Triplet& triplet);

}  // namespace imslam::training

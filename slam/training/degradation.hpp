#pragma once

#include <cstdint>
#include <vector>

namespace imslam::training {

/// Smear along straight segments centred on the pixel. The segment's vector [px] is affine in the
/// place, x and y running from -1 to 1 over the image: what a pan, roll and zoom do.
struct MotionBlur {
  float u = 0.0F, v = 0.0F;      ///< in the middle
  float u_x = 0.0F, u_y = 0.0F;  ///< change of u towards the right and the lower border
  float v_x = 0.0F, v_y = 0.0F;
};

/// Gaussian blur; its share of each pixel is 1 in the middle and changes linearly with the place,
/// within [0, 1], as at the border of a lens's focus.
struct DefocusBlur {
  float sigma = 0.0F;  ///< [px]
  float share_x = 0.0F, share_y = 0.0F;
};

/// What bad light, air, lens and sensor do to one view. The defaults change nothing.
///
///   light    = haze airlight + (1 - haze) grey                     then motion blur, then defocus
///   electric = min(255, gain darkness vignette light) + n,  n ~ N(0, read^2 + shot electric)
///   grey     = round(255 (min(1, amplification electric / 255))^gamma)
struct ViewDegradation {
  float haze = 0.0F;        ///< share of the airlight
  float airlight = 255.0F;  ///< grey
  MotionBlur motion;
  DefocusBlur defocus;
  float gain = 1.0F;                           ///< of the exposure
  float darkness = 1.0F;                       ///< share of the light that is left
  float vignetting = 0.0F;                     ///< loss of light in the farthest corner
  float vignette_x = 0.0F, vignette_y = 0.0F;  ///< its centre, within -1 and 1
  float read_noise = 0.0F;                     ///< sigma [grey levels]
  float shot_noise = 0.0F;                     ///< variance per grey level [grey levels]
  float amplification = 1.0F;                  ///< after the noise
  float gamma = 1.0F;
  int hot_pixels = 0;
  std::uint64_t hot_seed = 0;  ///< where they are: a camera keeps its own
  bool quantise = false;       ///< to whole grey levels
};

/// `grey`: row major, width * height, [0, 255]; stays in that range. Deterministic.
void degrade(const ViewDegradation& degradation,
             int width,
             int height,
             std::uint64_t noise_seed,
             std::vector<float>& grey);

}  // namespace imslam::training

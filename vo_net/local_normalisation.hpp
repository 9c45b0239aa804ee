#pragma once

#include "slam/base/config.hpp"
#include "slam/nn/tape.hpp"

namespace imslam::vo {

struct LocalNormalisationOptions {
  int small_radius = 7;      ///< [px] windows of 15 x 15: texture
  int large_radius = 30;     ///< [px] windows of 61 x 61: shading and shape
  double noise_floor = 1.0;  ///< [grey levels of 255] contrast that is not amplified any more

  void describe(Config& config);
  void validate() const;  ///< Throws InputError naming key, value and bound.
};

/// The image that the networks see: each pixel compared with its surroundings, at two sizes.
///
///   z_k(p) = (I(p) - mean_k(p)) / sqrt(variance_k(p) + noise_floor^2)
///   mean_k, variance_k: over the square of radius r_k around p, as far as it lies in the image
///
///   image [N,H,W,1] in grey levels of 255    y [N,H,W,2], a constant (no gradient)
///
/// Gain and offset of the exposure cancel above the noise floor: z of a I + b is z of I. Flat
/// images give 0. Box sums slide, so the cost per pixel does not depend on the radius. |z| < 2 r_k
/// + 1. Throws ContractError unless all pixels are finite.
template <typename S>
nn::Var local_normalisation(nn::Tape<S>& tape,
                            nn::Var image,
                            const LocalNormalisationOptions& options);

}  // namespace imslam::vo

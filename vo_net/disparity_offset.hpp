#pragma once

#include <vector>

#include "slam/base/config.hpp"
#include "slam/sensors/motion.hpp"
#include "vo_net/pose_layer.hpp"

namespace imslam::vo {

/// The constant offset of measured disparities, measured = true + offset: what is left of the
/// rectification.
struct DisparityOffsetEstimate {
  double offset_px = 0.0;
  double sigma_px = 1.0;  ///< standard deviation, scatter and what all frames share included
  int frames = 0;
};

/// The motion as it would have come out with that offset, to first order:
/// T Exp(J_disparity_offset (offset - motion.disparity_offset)).
RelativeMotion with_disparity_offset(const RelativeMotion& motion, double offset_px);

struct DisparityOffsetOptions {
  int block = 10;             ///< [frames] that share a scene, averaged before scatter is judged
  double prior = 0.0;         ///< [px] the offset to expect before anything was seen
  double prior_sigma = 0.25;  ///< [px] and how far from that it may be
  /// [1] The share of cameras whose rectification is exact: within exact_sigma of `prior`.
  double exact = 0.0;
  double exact_sigma = 0.01;  ///< [px]
  double systematic = 0.015;  ///< [1] sigma of what all frames share, of a single point's
  double kernel_width = 2.0;  ///< [standard deviations] blocks beyond count less

  void describe(Config& config);
  void validate() const;
};

/// Collects what each frame's pose layer says about the offset.
///
/// A frame gives x_i with information h_i (the profile likelihood of solve_pose). Frames of one
/// scene share errors of matching and of the lens model, which h_i does not know. So frames are
/// averaged over blocks, and the blocks combined as in a random-effects model,
///
///   x_b = offset + s_b z + N(0, 1/h_b + tau^2),   z ~ N(0, 1),   s_b = systematic sqrt(n_b / h_b)
///
/// the variance tau^2 between blocks being estimated by moments (DerSimonian & Laird,
/// "Meta-analysis in clinical trials", 1986), with Huber weights on the blocks and a prior. z is
/// one for all blocks: matches in blur or darkness are a little too short, which looks like an
/// offset and does not average out; n_b points that would each know it to sqrt(n_b / h_b).
///
/// The prior is a mixture ("spike and slab"; Mitchell & Beauchamp, "Bayesian variable selection in
/// linear regression", 1988) of cameras that were rectified exactly and others. An estimate of the
/// size of its own sigma would make the scale worse, not better: it is taken for what it most
/// likely is, nothing; one of several sigma stays what it is. Mean and variance of the mixture.
class DisparityOffsetEstimator {
 public:
  explicit DisparityOffsetEstimator(const DisparityOffsetOptions& options) : options_(options) {}

  /// Results that are not valid count for nothing.
  void add(const PoseLayerResult& result);

  DisparityOffsetEstimate estimate() const;

 private:
  struct Block {
    double information = 0.0;
    double weighted = 0.0;  ///< sum h_i x_i
    double points = 0.0;    ///< sum n_i
    int frames = 0;
  };
  void merge_pairs();

  DisparityOffsetOptions options_;
  std::vector<Block> blocks_;
  int frames_per_block_ = 0;
  int frames_ = 0;
};

}  // namespace imslam::vo

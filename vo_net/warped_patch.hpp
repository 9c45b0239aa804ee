#pragma once

#include <Eigen/Core>

#include "vo_net/patch_aligner.hpp"

namespace imslam::vo {

/// Where a patch of one image is expected in another one, and how it is distorted there.
struct PatchWarp {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();               ///< [px] in the source image
  Eigen::Vector2d expected = Eigen::Vector2d::Zero();             ///< [px] in the target image
  Eigen::Matrix2d A_target_source = Eigen::Matrix2d::Identity();  ///< d(target)/d(source)

  PatchWarp inverse() const { return {expected, center, A_target_source.inverse()}; }
};

/// The template as it should look at level `target_level` of the target image. The source level is
/// chosen so that the warp neither aliases nor blurs. False: outside the source image, too strongly
/// distorted, or without texture.
bool take_warped(const ImagePyramid& source,
                 const PatchWarp& warp,
                 int target_level,
                 int window,
                 PatchTemplate& patch);

/// Coarse to fine from `start` [px at full size], the template warped anew at every level.
Alignment align_warped(const ImagePyramid& source,
                       const PatchWarp& warp,
                       const ImagePyramid& target,
                       const Eigen::Vector2d& start,
                       int coarsest_level,
                       int finest_level,
                       const AlignOptions& options);

}  // namespace imslam::vo

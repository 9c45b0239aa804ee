#pragma once

#include "slam/nn/tensor.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/correspondence.hpp"

namespace imslam::vo {

/// A flow field of any image on one small grid: what the pose head sees.
///
///   [N, kRows, kColumns, kChannels]   per cell  [flow_x flow_y  confidence  x y]
///
///   flow = ((u1 - u0) / fx, (v1 - v0) / fy)      the mean over the cell's points, by weight
///   confidence = min(1, sum of weights)          0: no point here, then flow = 0
///   (x, y) = ((u - cx) / fx, (v - cy) / fy)      intrinsics layer: the mean place of the points
///                                                that the flow belongs to, else the cell's centre
///
/// Everything is in units of the focal length, so no camera and no resolution is special. The
/// intrinsics layer of the published network, (u - cx + 0.5) / fx, counts pixels from their corner;
/// here u is where project() puts it.
struct FlowGrid {
  static constexpr nn::Index kRows = 32;
  static constexpr nn::Index kColumns = 48;
  enum Channel : nn::Index { kFlowX, kFlowY, kConfidence, kPlaceX, kPlaceY, kChannels };

  static nn::Tensor<float> make(nn::Index samples) {
    return nn::Tensor<float>({samples, kRows, kColumns, kChannels});
  }

  /// Overwrites one sample. Correspondences that are not finite, outside the image or without
  /// weight count for nothing.
  static void fill(const Correspondences& correspondences,
                   const StereoCamera& camera,
                   nn::Index sample,
                   nn::Tensor<float>& grids);
};

}  // namespace imslam::vo

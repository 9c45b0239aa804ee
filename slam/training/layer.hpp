#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>

#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"

namespace imslam::training {

/// A textured plane, endless or cut out along an outline, in the frame of left0.
///
///   on the plane        plane . X = 1           so plane . (ray through a pixel) = inverse depth
///   pattern coordinate  s = axis_s . (X - origin), t likewise; a cut-out lies in |s|, |t| <= 1
///   texture coordinate  tile = tile_axis . (X - origin) + tile_offset
///   grey                255 (offset + gain texture)
struct Layer {
  static constexpr int kEndless = -1;

  Eigen::Vector3d plane = Eigen::Vector3d::UnitZ();        ///< [1/m]
  Eigen::Vector3d origin = Eigen::Vector3d::UnitZ();       ///< [m], on the plane
  Eigen::Vector3d axis_s = Eigen::Vector3d::UnitX();       ///< [1/m], in the plane
  Eigen::Vector3d axis_t = Eigen::Vector3d::UnitY();       ///< [1/m], in the plane
  Eigen::Vector3d tile_axis_u = Eigen::Vector3d::UnitX();  ///< [tiles/m], in the plane
  Eigen::Vector3d tile_axis_v = Eigen::Vector3d::UnitY();  ///< [tiles/m], in the plane
  Eigen::Vector2d tile_offset = Eigen::Vector2d::Zero();   ///< [tiles]
  int shape = kEndless;                                    ///< in the ShapeBank
  std::size_t texture = 0;                                 ///< in the TexturePool
  double gain = 1.0;
  double offset = 0.0;
  lie::SE3d motion;  ///< of its points from t-1 to t, in left0; identity: does not move by itself
};

/// A layer as one camera sees it: everything is affine in the pixel x = [u v 1], over the
/// inverse depth.
///
///   inverse depth = inverse_depth . x,   s = (s . x) / (inverse_depth . x),   ...
struct LayerImage {
  Eigen::Vector3d inverse_depth, s, t, tile_u, tile_v;
  /// Around all that is seen of it [px].
  double left = -std::numeric_limits<double>::infinity();
  double right = std::numeric_limits<double>::infinity();
  double top = -std::numeric_limits<double>::infinity();
  double bottom = std::numeric_limits<double>::infinity();
};

/// `T_camera_left0` carries the layer's points into the camera's frame: its own motion included.
LayerImage project_layer(const Layer& layer,
                         const StereoCamera& camera,
                         const lie::SE3d& T_camera_left0);

/// Maps pixels [u v 1] of left0 that see the layer to homogeneous pixels of the camera; the third
/// component is positive in front of it.
Eigen::Matrix3d layer_homography(const Layer& layer,
                                 const StereoCamera& camera,
                                 const lie::SE3d& T_camera_left0);

}  // namespace imslam::training

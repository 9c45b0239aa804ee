#pragma once

#include <cstddef>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/training/layer.hpp"

namespace imslam {
class Config;
}

namespace imslam::training {

/// What scenes are drawn from.
struct SceneOptions {
  int width = 384;               ///< [px], a multiple of 16
  int height = 256;              ///< [px], a multiple of 16
  double least_disparity = 8.0;  ///< [px] of the nearest thing: the smallest that is drawn
  double most_disparity = 96.0;  ///< [px] of the nearest thing: the largest that is drawn
  double rotation_flow = 80.0;   ///< [px] most flow at the image's centre by turning the camera
  double parallax_flow = 40.0;   ///< [px] most flow of the nearest thing by moving it sideways
  double object_flow = 20.0;     ///< [px] sigma of the flow of things that move by themselves
  double moving_share = 0.15;    ///< of the cut-outs
  double still_share = 0.03;     ///< of the scenes: the camera rests

  void describe(Config& config);
  void validate() const;
};

/// One random world of planes, and the camera before and after its motion. Layers are sorted, the
/// nearest first; the last one is endless, far and seen in every direction of the views.
struct LayeredScene {
  StereoCamera camera;
  lie::SE3d T_left1_left0;
  std::vector<Layer> layers;

  lie::SE3d T_right0_left0() const;
  /// Of the layer's points, its own motion included.
  lie::SE3d T_left1_layer(const Layer& layer) const { return T_left1_left0 * layer.motion; }
};

/// What a layer must know of a texture to choose its scale and contrast.
struct TextureFacts {
  int size = 0;            ///< [texels]
  double mean = 0.0;       ///< in [0, 1]
  double deviation = 0.0;  ///< standard, in [0, 1]
  double detail = 0.0;     ///< mean difference of neighbours two texels wide, in [0, 1]
};

/// What the layers may choose from.
struct SceneStock {
  std::vector<TextureFacts> textures;
  std::size_t shapes = 0;
};

LayeredScene draw_scene(const SceneOptions& options, const SceneStock& stock, Random random);

}  // namespace imslam::training

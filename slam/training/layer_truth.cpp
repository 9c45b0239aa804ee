#include "slam/training/layer_truth.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace imslam::training {
namespace {

constexpr int kTile = 16;  ///< [px]

/// Tells whether a point of a layer is seen at a place of a view.
class SightTest {
 public:
  SightTest(const LayeredScene& scene, const ShapeBank& shapes, const SeenScene& seen)
      : scene_(scene),
        shapes_(shapes),
        seen_(seen),
        width_(scene.camera.width),
        height_(scene.camera.height),
        tile_columns_((width_ + kTile - 1) / kTile) {
    const int tile_rows = (height_ + kTile - 1) / kTile;
    cut_outs_.resize(static_cast<std::size_t>(tile_rows * tile_columns_));
    for (std::size_t i = 0; i < scene.layers.size(); ++i) {
      if (scene.layers[i].shape == Layer::kEndless) {
        endless_.push_back(i);
      } else {
        enter_into_tiles(i, tile_rows);
      }
    }
  }

  MatchState operator()(double u, double v, std::int32_t layer) const {
    constexpr double kRounding = 1e-6;  // what does not move must not leave the image
    const bool inside = u >= -kRounding && v >= -kRounding && u <= width_ - 1 + kRounding &&
                        v <= height_ - 1 + kRounding;
    if (!inside) return MatchState::kOutside;
    const Eigen::Vector3d pixel(u, v, 1.0);
    const auto own = static_cast<std::size_t>(layer);
    const double own_inverse_depth = seen_.images[own].inverse_depth.dot(pixel);
    const int column = static_cast<int>(u);
    const int row = static_cast<int>(v);
    const auto tile = static_cast<std::size_t>(row / kTile * tile_columns_ + column / kTile);
    for (const std::size_t other : cut_outs_[tile])
      if (other != own && stands_before(other, pixel, own_inverse_depth))
        return MatchState::kHidden;
    // Where one layer is the nearest at four places, no endless one comes before it between them:
    // their difference is affine.
    if (surrounded_by(column, row, layer)) return MatchState::kVisible;
    for (const std::size_t other : endless_)
      if (other != own && stands_before(other, pixel, own_inverse_depth))
        return MatchState::kHidden;
    return MatchState::kVisible;
  }

 private:
  void enter_into_tiles(std::size_t layer, int tile_rows) {
    const LayerImage& image = seen_.images[layer];
    const auto tile = [](double at, int count) {
      return static_cast<int>(std::clamp(std::floor(at / kTile), -1.0, static_cast<double>(count)));
    };
    const int last_row = std::min(tile(image.bottom, tile_rows), tile_rows - 1);
    const int last_column = std::min(tile(image.right, tile_columns_), tile_columns_ - 1);
    for (int row = std::max(tile(image.top, tile_rows), 0); row <= last_row; ++row) {
      for (int column = std::max(tile(image.left, tile_columns_), 0); column <= last_column;
           ++column) {
        cut_outs_[static_cast<std::size_t>(row * tile_columns_ + column)].push_back(layer);
      }
    }
  }

  bool surrounded_by(int column, int row, std::int32_t layer) const {
    const std::int32_t* at = seen_.view.layer.data() + row * width_ + column;
    const std::int32_t* below = row + 1 < height_ ? at + width_ : at;
    const int right = column + 1 < width_ ? 1 : 0;
    return at[0] == layer && at[right] == layer && below[0] == layer && below[right] == layer;
  }

  bool stands_before(std::size_t other,
                     const Eigen::Vector3d& pixel,
                     double own_inverse_depth) const {
    const LayerImage& image = seen_.images[other];
    const double inverse_depth = image.inverse_depth.dot(pixel);
    if (!(inverse_depth > own_inverse_depth)) return false;
    const int shape = scene_.layers[other].shape;
    return shape == Layer::kEndless ||
           shapes_.inside(static_cast<std::size_t>(shape), image.s.dot(pixel) / inverse_depth,
                          image.t.dot(pixel) / inverse_depth);
  }

  const LayeredScene& scene_;
  const ShapeBank& shapes_;
  const SeenScene& seen_;
  int width_;
  int height_;
  int tile_columns_;
  std::vector<std::size_t> endless_;
  std::vector<std::vector<std::size_t>> cut_outs_;  ///< that may be seen in each tile of the view
};

}  // namespace

void write_disparity(const LayeredScene& scene,
                     const ShapeBank& shapes,
                     const SeenScene& left0,
                     const SeenScene& right0,
                     Triplet& triplet) {
  const StereoCamera& camera = scene.camera;
  const SightTest sight(scene, shapes, right0);
  triplet.disparity.resize(left0.view.layer.size());
  triplet.disparity_state.resize(left0.view.layer.size());
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const std::size_t at = triplet.index(row, column);
      const std::int32_t layer = left0.view.layer[at];
      const Eigen::Vector3d& inverse_depth =
          left0.images[static_cast<std::size_t>(layer)].inverse_depth;
      const double disparity =
          camera.fx * camera.baseline_m *
          (inverse_depth.x() * column + inverse_depth.y() * row + inverse_depth.z());
      triplet.disparity[at] = static_cast<float>(disparity);
      triplet.disparity_state[at] = sight(column - disparity, row, layer);
    }
  }
}

void write_flow(const LayeredScene& scene,
                const ShapeBank& shapes,
                const SeenScene& left0,
                const SeenScene& left1,
                Triplet& triplet) {
  const StereoCamera& camera = scene.camera;
  const SightTest sight(scene, shapes, left1);
  std::vector<Eigen::Matrix3d> homographies;
  for (const Layer& layer : scene.layers)
    homographies.push_back(layer_homography(layer, camera, scene.T_left1_layer(layer)));
  triplet.flow_u.resize(left0.view.layer.size());
  triplet.flow_v.resize(left0.view.layer.size());
  triplet.flow_state.resize(left0.view.layer.size());
  constexpr double kLeastDepthRatio = 1e-3;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const std::size_t at = triplet.index(row, column);
      const std::int32_t layer = left0.view.layer[at];
      const Eigen::Vector3d target =
          homographies[static_cast<std::size_t>(layer)] * Eigen::Vector3d(column, row, 1.0);
      if (target.z() < kLeastDepthRatio) {
        triplet.flow_u[at] = triplet.flow_v[at] = 0.0F;
        triplet.flow_state[at] = MatchState::kNone;
        continue;
      }
      const double u = target.x() / target.z();
      const double v = target.y() / target.z();
      triplet.flow_u[at] = static_cast<float>(u - column);
      triplet.flow_v[at] = static_cast<float>(v - row);
      triplet.flow_state[at] = sight(u, v, layer);
    }
  }
}

}  // namespace imslam::training

#include "slam/training/layer_renderer.hpp"

#include <algorithm>

#include "slam/training/layer_lanes.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::training {
namespace {

using simulation::TexturePool;

/// Looks of an edge pixel about its centre [px]: no two share a row or a column.
constexpr std::size_t kLooks = 8;
constexpr float kLookX[kLooks] = {0.0625F,  -0.0625F, 0.3125F, -0.1875F,
                                  -0.3125F, -0.4375F, 0.1875F, 0.4375F};
constexpr float kLookY[kLooks] = {-0.1875F, 0.1875F,  0.0625F, -0.3125F,
                                  0.3125F,  -0.0625F, 0.4375F, -0.4375F};
static_assert(kLanes % kLooks == 0);

void bound(ImagePoints& points) {
  points.left = points.right = points.x[0];
  points.top = points.bottom = points.y[0];
  for (std::size_t i = 1; i < kLanes; ++i) {
    points.left = std::min(points.left, float{points.x[i]});
    points.right = std::max(points.right, float{points.x[i]});
    points.top = std::min(points.top, float{points.y[i]});
    points.bottom = std::max(points.bottom, float{points.y[i]});
  }
}

/// Shades points; what the lanes look at is kept from one call to the next.
class Brush {
 public:
  Brush(const std::vector<PackedLayer>& layers, const TexturePool& pool, float softness)
      : layers_(layers), pool_(pool), softness_(softness) {}

  void shade_nearest(const ImagePoints& points, Ints& nearest, Floats& grey) {
    find_nearest(layers_, points, nearest);
    std::int32_t change = 0;
    for (std::size_t i = 0; i < kLanes; ++i) change |= nearest[i] ^ aimed_at_[i];
    if (change != 0) {
      aim(layers_, pool_, nearest, lanes_);
      aimed_at_ = nearest;
    }
    shade(lanes_, pool_, points, softness_, grey);
  }

 private:
  const std::vector<PackedLayer>& layers_;
  const TexturePool& pool_;
  float softness_;
  LayerLanes lanes_{};
  Ints aimed_at_ = Ints{} - 1;
};

void render_centres(Brush& brush, int width, int height, LayerView& view) {
  ImagePoints points;
  for (int row = 0; row < height; ++row) {
    points.y = Floats{} + static_cast<float>(row);
    points.top = points.bottom = static_cast<float>(row);
    for (int column = 0; column < width; column += static_cast<int>(kLanes)) {
      for (std::size_t i = 0; i < kLanes; ++i)
        points.x[i] = static_cast<float>(column) + static_cast<float>(i);
      points.left = points.x[0];
      points.right = points.x[kLanes - 1];
      Ints nearest;
      Floats grey;
      brush.shade_nearest(points, nearest, grey);
      const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(column);
      std::memcpy(view.layer.data() + at, &nearest, sizeof nearest);
      std::memcpy(view.grey.data() + at, &grey, sizeof grey);
    }
  }
}

/// Pixels beside another layer.
std::vector<std::int32_t> edges_of(const LayerView& view, int width, int height) {
  std::vector<std::int32_t> edges;
  for (int row = 0; row < height; ++row) {
    const std::int32_t* here = view.layer.data() + row * width;
    const std::int32_t* above = row > 0 ? here - width : here;
    const std::int32_t* below = row + 1 < height ? here + width : here;
    for (int column = 0; column < width; ++column) {
      const std::int32_t own = here[column];
      const std::int32_t difference = (own ^ here[std::max(column - 1, 0)]) |
                                      (own ^ here[std::min(column + 1, width - 1)]) |
                                      (own ^ above[column]) | (own ^ below[column]);
      if (difference != 0) edges.push_back(row * width + column);
    }
  }
  return edges;
}

void smooth_edges(Brush& brush, int width, int height, LayerView& view) {
  constexpr std::size_t kPixels = kLanes / kLooks;
  const std::vector<std::int32_t> edges = edges_of(view, width, height);
  for (std::size_t first = 0; first < edges.size(); first += kPixels) {
    ImagePoints points;
    for (std::size_t i = 0; i < kLanes; ++i) {
      const std::int32_t pixel = edges[std::min(first + i / kLooks, edges.size() - 1)];
      points.x[i] = static_cast<float>(pixel % width) + kLookX[i % kLooks];
      points.y[i] = static_cast<float>(pixel / width) + kLookY[i % kLooks];
    }
    bound(points);
    Ints nearest;
    Floats grey;
    brush.shade_nearest(points, nearest, grey);
    for (std::size_t k = 0; k < kPixels && first + k < edges.size(); ++k) {
      float sum = 0.0F;
      for (std::size_t look = 0; look < kLooks; ++look) sum += grey[k * kLooks + look];
      view.grey[static_cast<std::size_t>(edges[first + k])] = sum / kLooks;
    }
  }
}

}  // namespace

void LayerRenderer::render(const LayeredScene& scene,
                           const LayerImages& images,
                           float softness,
                           LayerView& view) const {
  const int width = scene.camera.width;
  const int height = scene.camera.height;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  view.grey.resize(pixels);
  view.layer.resize(pixels);
  const std::vector<PackedLayer> layers = pack_layers(scene.layers, images, shapes_);
  Brush brush(layers, pool_, softness);
  render_centres(brush, width, height, view);
  smooth_edges(brush, width, height, view);
}

}  // namespace imslam::training

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "datasets/simulation/view.hpp"
#include "slam/base/parallel.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kTile = RayTable::kTile;
constexpr auto kTileLanes = static_cast<std::size_t>(kTile);
static_assert(kTileLanes * kTileLanes == kLanes);

/// Where the finer rays of an edge pixel go, in pixels: a rotated grid, every row and column of a
/// 4 x 4 raster once.
constexpr std::size_t kSubRays = 4;
constexpr float kSubRay[kSubRays][2] = {
    {-0.125F, -0.375F}, {0.375F, -0.125F}, {-0.375F, 0.125F}, {0.125F, 0.375F}};
/// A tile with more edge pixels than this shows a long edge or foliage: a ray near each corner of
/// the pixels, shared by the four about it, then costs less and says more than four of each pixel.
constexpr int kBusy = 5;
/// How far from the corner the ray goes [px], to and fro in turn, so that upright and level edges
/// meet the rays of a pixel one after the other.
constexpr float kOffCorner = 0.125F;
constexpr float kCentreWeight = 2.0F;  ///< of the ray through the centre; a corner's is 1
/// Steps of radiance smaller than this share of it are left as they are: less than sensor noise.
constexpr float kInvisible = 0.05F;

/// Rays of a packet, bent by lane-wise shares of the change per pixel.
IMSLAM_FOR_EACH_PROCESSOR void shift(const Floats& columns, const Floats& rows, RayPacket& packet) {
  Floats3& d = packet.direction;
  d.x += columns * packet.d_column.x + rows * packet.d_row.x;
  d.y += columns * packet.d_column.y + rows * packet.d_row.y;
  d.z += columns * packet.d_column.z + rows * packet.d_row.z;
  // A shift of half a pixel changes the length by about 1e-6: one Newton step makes it 1 again.
  const Floats longer = 1.5F - 0.5F * (d.x * d.x + d.y * d.y + d.z * d.z);
  d.x *= longer;
  d.y *= longer;
  d.z *= longer;
}

class Renderer {
 public:
  Renderer(const World& world, const RayTable& rays, const lie::SE3d& T_world_camera, View& view)
      : world_(world),
        rays_(rays),
        R_(T_world_camera.rotation().matrix().cast<float>()),
        origin_(T_world_camera.translation().cast<float>()),
        view_(view) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      corner_columns_[i] = 0.5F + (i / kTileLanes % 2 == 0 ? kOffCorner : -kOffCorner);
      corner_rows_[i] = 0.5F + (i % 2 == 0 ? kOffCorner : -kOffCorner);
      sub_columns_[i] = kSubRay[i % kSubRays][0];
      sub_rows_[i] = kSubRay[i % kSubRays][1];
    }
  }

  /// One ray through the centre of every pixel of a row of tiles.
  void centres(int tile_row) const {
    for (int tile_column = 0; tile_column < rays_.tile_columns(); ++tile_column) {
      SeenPacket seen;
      look(rays_.tile_packet(R_, tile_row, tile_column), 1.0F, seen);
      for_each_row(tile_row, tile_column, [&](std::size_t at, std::size_t lane, std::size_t lanes) {
        store(&seen.radiance, lane, lanes, &view_.radiance[at]);
        store(&seen.distance, lane, lanes, &view_.distance[at]);
        std::copy_n(seen.surface + lane, lanes, &view_.surface[at]);
        std::copy_n(seen.instance + lane, lanes, &view_.instance[at]);
      });
    }
  }

  /// Marks the busy tiles of a row of tiles.
  void find_busy(int tile_row, std::vector<std::uint8_t>& busy) const {
    for (int tile_column = 0; tile_column < rays_.tile_columns(); ++tile_column) {
      int count = 0;
      for_each_edge(tile_row, tile_column, [&](int, int) { ++count; });
      busy[tile_index(tile_row, tile_column)] = count > kBusy ? 1 : 0;
    }
  }

  /// Means of finer rays for the pixels at clean edges of a row of tiles, written to `smooth`, and
  /// the rays at the lower right corners of pixels where a busy tile needs them, to `corners`.
  void edges(int tile_row,
             const std::vector<std::uint8_t>& busy,
             std::vector<float>& smooth,
             std::vector<float>& corners) const {
    Queue queue;
    for (int tile_column = 0; tile_column < rays_.tile_columns(); ++tile_column) {
      if (touches_busy(tile_row, tile_column, busy)) trace_corners(tile_row, tile_column, corners);
      if (busy[tile_index(tile_row, tile_column)] != 0) continue;
      for_each_edge(tile_row, tile_column,
                    [&](int row, int column) { enqueue(view_.index(row, column), queue, smooth); });
    }
    refine(queue, smooth);
  }

  /// Mixes the centres of the pixels of busy tiles with the four corners about them. Fewer would
  /// pull edges to their side, so the first row and column of the image do without.
  void mix(std::size_t row,
           const std::vector<std::uint8_t>& busy,
           const std::vector<float>& corners,
           std::vector<float>& smooth) const {
    if (row == 0) return;
    for (int column = 1; column < view_.width; ++column) {
      if (busy[tile_index(static_cast<int>(row) / kTile, column / kTile)] == 0) continue;
      const std::size_t at = view_.index(static_cast<int>(row), column);
      const std::size_t above = at - static_cast<std::size_t>(view_.width);
      const float sum = corners[at] + corners[at - 1] + corners[above] + corners[above - 1];
      smooth[at] = (kCentreWeight * view_.radiance[at] + sum) / (kCentreWeight + 4.0F);
    }
  }

 private:
  /// Edge pixels that wait until their rays fill a packet.
  struct Queue {
    std::array<std::size_t, kLanes / kSubRays> pixels = {};
    std::size_t count = 0;
    RayPacket rays;
  };

  void look(const RayPacket& rays, float footprint, SeenPacket& seen) const {
    std::array<Hit, kLanes> hits;
    world_.closest(origin_, rays, true, hits.data());
    world_.look(origin_, rays, hits.data(), footprint, seen);
  }

  static void store(const Floats* from, std::size_t lane, std::size_t lanes, float* to) {
    std::memcpy(to, reinterpret_cast<const char*>(from) + lane * sizeof(float),
                lanes * sizeof(float));
  }

  /// Calls store_row(index in the view, first lane, lanes) for the rows of a tile in the image.
  template <typename StoreRow>
  void for_each_row(int tile_row, int tile_column, const StoreRow& store_row) const {
    const int first_row = tile_row * kTile;
    const int first_column = tile_column * kTile;
    const int lanes = std::min(kTile, view_.width - first_column);
    for (int i = 0; i < std::min(kTile, view_.height - first_row); ++i) {
      store_row(view_.index(first_row + i, first_column), static_cast<std::size_t>(i) * kTileLanes,
                static_cast<std::size_t>(lanes));
    }
  }

  std::size_t tile_index(int tile_row, int tile_column) const {
    return static_cast<std::size_t>(tile_row * rays_.tile_columns() + tile_column);
  }

  /// Whether a pixel of a busy tile has a corner in this tile.
  bool touches_busy(int tile_row, int tile_column, const std::vector<std::uint8_t>& busy) const {
    const int last_row = std::min(tile_row + 1, rays_.tile_rows() - 1);
    const int last_column = std::min(tile_column + 1, rays_.tile_columns() - 1);
    return busy[tile_index(tile_row, tile_column)] != 0 ||
           busy[tile_index(tile_row, last_column)] != 0 ||
           busy[tile_index(last_row, tile_column)] != 0 ||
           busy[tile_index(last_row, last_column)] != 0;
  }

  /// Calls visit(row, column) for the edge pixels of a tile.
  template <typename Visit>
  void for_each_edge(int tile_row, int tile_column, const Visit& visit) const {
    const int first_row = tile_row * kTile;
    const int first_column = tile_column * kTile;
    for (int row = first_row; row < std::min(first_row + kTile, view_.height); ++row) {
      for (int column = first_column; column < std::min(first_column + kTile, view_.width);
           ++column) {
        if (at_edge(row, column)) visit(row, column);
      }
    }
  }

  /// Whether a direct neighbour shows another surface in another brightness.
  bool at_edge(int row, int column) const {
    const std::size_t at = view_.index(row, column);
    const std::uint32_t surface = view_.surface[at];
    const float radiance = view_.radiance[at];
    const auto differs = [&](bool inside, std::size_t other) {
      return inside && view_.surface[other] != surface &&
             std::abs(view_.radiance[other] - radiance) > kInvisible * radiance;
    };
    const auto width = static_cast<std::size_t>(view_.width);
    return differs(column > 0, at - 1) || differs(column + 1 < view_.width, at + 1) ||
           differs(row > 0, at - width) || differs(row + 1 < view_.height, at + width);
  }

  void trace_corners(int tile_row, int tile_column, std::vector<float>& corners) const {
    RayPacket rays = rays_.tile_packet(R_, tile_row, tile_column);
    shift(corner_columns_, corner_rows_, rays);
    SeenPacket seen;
    look(rays, 0.5F, seen);
    for_each_row(tile_row, tile_column, [&](std::size_t at, std::size_t lane, std::size_t lanes) {
      store(&seen.radiance, lane, lanes, &corners[at]);
    });
  }

  void enqueue(std::size_t pixel, Queue& queue, std::vector<float>& smooth) const {
    const auto width = static_cast<std::size_t>(view_.width);
    for (std::size_t i = 0; i < kSubRays; ++i) {
      rays_.add_pixel(R_, static_cast<int>(pixel / width), static_cast<int>(pixel % width),
                      queue.rays);
    }
    queue.pixels[queue.count++] = pixel;
    if (queue.count == queue.pixels.size()) refine(queue, smooth);
  }

  /// Empties the queue.
  void refine(Queue& queue, std::vector<float>& smooth) const {
    if (queue.count == 0) return;
    shift(sub_columns_, sub_rows_, queue.rays);
    SeenPacket seen;
    look(queue.rays, 0.5F, seen);
    for (std::size_t k = 0; k < queue.count; ++k) {
      float sum = 0.0F;
      for (std::size_t i = k * kSubRays; i < (k + 1) * kSubRays; ++i) sum += seen.radiance[i];
      smooth[queue.pixels[k]] = sum / static_cast<float>(kSubRays);
    }
    queue.count = 0;
    queue.rays.count = 0;
  }

  const World& world_;
  const RayTable& rays_;
  Eigen::Matrix3f R_;
  Vector3f origin_;
  View& view_;
  Floats corner_columns_, corner_rows_;  ///< where the rays of a busy tile go [px]
  Floats sub_columns_, sub_rows_;        ///< where the rays of four edge pixels go [px]
};

}  // namespace

void render_view(const World& world,
                 const RayTable& rays,
                 const lie::SE3d& T_world_camera,
                 bool antialias,
                 View& view) {
  view.width = rays.width();
  view.height = rays.height();
  const auto count = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  view.radiance.resize(count);
  view.distance.resize(count);
  view.surface.resize(count);
  view.instance.resize(count);
  const Renderer renderer(world, rays, T_world_camera, view);
  const auto tile_rows = static_cast<std::size_t>(rays.tile_rows());
  parallel_for(tile_rows, [&](std::size_t i) { renderer.centres(static_cast<int>(i)); });
  if (!antialias) return;
  std::vector<std::uint8_t> busy(tile_rows * static_cast<std::size_t>(rays.tile_columns()));
  parallel_for(tile_rows, [&](std::size_t i) { renderer.find_busy(static_cast<int>(i), busy); });
  std::vector<float> smooth = view.radiance;
  std::vector<float> corners(count);
  parallel_for(tile_rows,
               [&](std::size_t i) { renderer.edges(static_cast<int>(i), busy, smooth, corners); });
  parallel_for(static_cast<std::size_t>(view.height),
               [&](std::size_t row) { renderer.mix(row, busy, corners, smooth); });
  view.radiance.swap(smooth);
}

}  // namespace imslam::simulation

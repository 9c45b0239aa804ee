#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "datasets/simulation/view.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kTile = 4;  ///< a packet is a square of kTile x kTile pixels: its rays stay together
constexpr std::size_t kLanes = RayPacket::kLanes;
static_assert(kTile * kTile == static_cast<int>(kLanes));

/// Where the finer rays of an edge pixel go, in pixels.
struct SubRays {
  std::size_t count;
  float offsets[4][2];
  float centre_weight;  ///< of the ray that is there already
};
/// Along a clean edge: a rotated grid, every row and column of a 4 x 4 raster once.
constexpr SubRays kClean = {
    4, {{-0.125F, -0.375F}, {0.375F, -0.125F}, {-0.375F, 0.125F}, {0.125F, 0.375F}}, 0.0F};
/// In foliage, where most neighbours differ and no edge can be followed: a diagonal and the centre.
constexpr SubRays kBusy = {2, {{-0.3F, -0.3F}, {0.3F, 0.3F}, {}, {}}, 1.0F};
constexpr int kBusyNeighbours = 3;
/// Steps of radiance smaller than this share of it are left as they are: less than sensor noise.
constexpr float kInvisible = 0.05F;

void fill(RayPacket& packet, std::size_t lane, const Vector3f& direction) {
  packet.x[lane] = direction.x();
  packet.y[lane] = direction.y();
  packet.z[lane] = direction.z();
}

/// World directions of a band of kTile rows and one row and column of margin all around.
class Band {
 public:
  Band(const RayTable& rays, const Eigen::Matrix3f& R_world_camera, int first_row)
      : width_(rays.width() + 2), first_row_(first_row) {
    directions_.resize(static_cast<std::size_t>((kTile + 2) * width_));
    for (int row = first_row - 1; row <= std::min(first_row + kTile, rays.height()); ++row) {
      const Vector3f* from = &rays.direction(row, -1);
      Vector3f* to = &directions_[index(row, -1)];
      for (int i = 0; i < width_; ++i) to[i] = R_world_camera * from[i];
    }
  }

  Ray ray(const Vector3f& origin, int row, int column) const {
    const Vector3f* here = &directions_[index(row, column)];
    return {origin, *here, 0.5F * (here[1] - here[-1]), 0.5F * (here[width_] - here[-width_])};
  }

 private:
  std::size_t index(int row, int column) const {
    return static_cast<std::size_t>((row - first_row_ + 1) * width_ + column + 1);
  }

  int width_;
  int first_row_;
  std::vector<Vector3f> directions_;
};

class Renderer {
 public:
  Renderer(const World& world, const RayTable& rays, const lie::SE3d& T_world_camera, View& view)
      : world_(world),
        rays_(rays),
        R_(T_world_camera.rotation().matrix().cast<float>()),
        origin_(T_world_camera.translation().cast<float>()),
        view_(view) {}

  /// One ray through the centre of every pixel of kTile rows.
  void first_rays(int first_row) const {
    const Band band(rays_, R_, first_row);
    for (int column = 0; column < view_.width; column += kTile) first_tile(band, first_row, column);
  }

  /// Means of finer rays for the edge pixels of kTile rows, written to `smooth`.
  void edges(int first_row, std::vector<float>& smooth) const {
    const Band band(rays_, R_, first_row);
    const int end = std::min(first_row + kTile, view_.height);
    Queue clean{kClean, {}, 0};
    Queue busy{kBusy, {}, 0};
    for (int column = 0; column < view_.width; ++column) {
      for (int row = first_row; row < end; ++row) {
        const int differing = differing_neighbours(row, column);
        if (differing == 0) continue;
        Queue& queue = differing < kBusyNeighbours ? clean : busy;
        queue.pixels[queue.count++] = {row, column};
        if ((queue.count + 1) * queue.sub_rays.count > kLanes) refine(band, queue, smooth);
      }
    }
    refine(band, clean, smooth);
    refine(band, busy, smooth);
  }

 private:
  struct Pixel {
    int row;
    int column;
  };

  /// Edge pixels that wait until their rays fill a packet.
  struct Queue {
    const SubRays& sub_rays;
    std::array<Pixel, kLanes> pixels;
    std::size_t count;
  };

  void first_tile(const Band& band, int first_row, int first_column) const {
    std::array<Pixel, kLanes> pixels;
    std::array<Ray, kLanes> rays;
    RayPacket packet;
    for (int row = first_row; row < std::min(first_row + kTile, view_.height); ++row) {
      for (int column = first_column; column < std::min(first_column + kTile, view_.width);
           ++column) {
        pixels[packet.count] = {row, column};
        rays[packet.count] = band.ray(origin_, row, column);
        fill(packet, packet.count, rays[packet.count].direction);
        ++packet.count;
      }
    }
    std::array<Hit, kLanes> hits;
    world_.closest(origin_, packet, true, hits.data());
    for (std::size_t i = 0; i < packet.count; ++i) {
      const Seen seen = world_.look(rays[i], hits[i], 1.0F);
      const std::size_t at = view_.index(pixels[i].row, pixels[i].column);
      view_.radiance[at] = seen.radiance;
      view_.distance[at] = seen.distance;
      view_.surface[at] = seen.surface;
      view_.instance[at] = seen.instance;
    }
  }

  /// Direct neighbours that show another surface in another brightness, 0 to 4.
  int differing_neighbours(int row, int column) const {
    const std::size_t at = view_.index(row, column);
    const std::uint32_t surface = view_.surface[at];
    const float radiance = view_.radiance[at];
    const auto differs = [&](bool inside, std::size_t other) {
      return inside && view_.surface[other] != surface &&
                     std::abs(view_.radiance[other] - radiance) > kInvisible * radiance
                 ? 1
                 : 0;
    };
    const auto width = static_cast<std::size_t>(view_.width);
    return differs(column > 0, at - 1) + differs(column + 1 < view_.width, at + 1) +
           differs(row > 0, at - width) + differs(row + 1 < view_.height, at + width);
  }

  /// Empties the queue.
  void refine(const Band& band, Queue& queue, std::vector<float>& smooth) const {
    if (queue.count == 0) return;
    const SubRays& sub = queue.sub_rays;
    RayPacket packet;
    packet.count = queue.count * sub.count;
    std::array<Ray, kLanes> rays;
    for (std::size_t i = 0; i < packet.count; ++i) {
      const Pixel& pixel = queue.pixels[i / sub.count];
      const float* offset = sub.offsets[i % sub.count];
      rays[i] = band.ray(origin_, pixel.row, pixel.column);
      rays[i].direction += offset[0] * rays[i].d_column + offset[1] * rays[i].d_row;
      rays[i].direction.normalize();
      fill(packet, i, rays[i].direction);
    }
    std::array<Hit, kLanes> hits;
    world_.closest(origin_, packet, true, hits.data());
    for (std::size_t k = 0; k < queue.count; ++k) {
      const std::size_t at = view_.index(queue.pixels[k].row, queue.pixels[k].column);
      float sum = sub.centre_weight * view_.radiance[at];
      for (std::size_t i = k * sub.count; i < (k + 1) * sub.count; ++i) {
        sum += world_.look(rays[i], hits[i], 0.5F).radiance;
      }
      smooth[at] = sum / (static_cast<float>(sub.count) + sub.centre_weight);
    }
    queue.count = 0;
  }

  const World& world_;
  const RayTable& rays_;
  Eigen::Matrix3f R_;
  Vector3f origin_;
  View& view_;
};

/// Pseudo-inverse of [d_column d_row].
Eigen::Matrix<float, 2, 3> inverse_of_steps(const Eigen::Vector3d& d_column,
                                            const Eigen::Vector3d& d_row) {
  Eigen::Matrix<double, 3, 2> J_direction_pixel;
  J_direction_pixel << d_column, d_row;
  const Eigen::Matrix2d normal = J_direction_pixel.transpose() * J_direction_pixel;
  if (normal.determinant() < 1e-24) return Eigen::Matrix<float, 2, 3>::Zero();
  return (normal.inverse() * J_direction_pixel.transpose()).cast<float>();
}

}  // namespace

RayTable::RayTable(const Lens& lens) : width_(lens.width()), height_(lens.height()) {
  const int columns = width_ + 2;
  std::vector<Eigen::Vector3d> wide(static_cast<std::size_t>((height_ + 2) * columns));
  parallel_for(static_cast<std::size_t>(height_ + 2), [&](std::size_t row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d pixel(column - 1.0, static_cast<double>(row) - 1.0);
      wide[row * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)] =
          lens.direction(pixel);
    }
  });
  directions_.reserve(wide.size());
  for (const Eigen::Vector3d& direction : wide) directions_.push_back(direction.cast<float>());
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const Eigen::Vector3d* here =
          &wide[static_cast<std::size_t>((row + 1) * columns + column + 1)];
      exact_.push_back(*here);
      pixel_changes_.push_back(
          inverse_of_steps(0.5 * (here[1] - here[-1]), 0.5 * (here[columns] - here[-columns])));
    }
  }
}

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
  const auto bands = static_cast<std::size_t>((view.height + kTile - 1) / kTile);
  parallel_for(bands, [&](std::size_t i) { renderer.first_rays(static_cast<int>(i) * kTile); });
  if (!antialias) return;
  std::vector<float> smooth = view.radiance;
  parallel_for(bands, [&](std::size_t i) { renderer.edges(static_cast<int>(i) * kTile, smooth); });
  view.radiance.swap(smooth);
}

}  // namespace imslam::simulation

#include <array>
#include <cstddef>

#include "datasets/simulation/view.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kLanes = static_cast<int>(RayPacket::kLanes);
constexpr int kSubRays = 4;
/// Rotated grid: every row and column of a 4 x 4 raster once.
constexpr float kOffsets[kSubRays][2] = {
    {-0.125F, -0.375F}, {0.375F, -0.125F}, {-0.375F, 0.125F}, {0.125F, 0.375F}};

class Pass {
 public:
  Pass(const World& world, const RayTable& rays, const lie::SE3d& T_world_camera, View& view)
      : world_(world),
        rays_(rays),
        R_(T_world_camera.rotation().matrix().cast<float>()),
        origin_(T_world_camera.translation().cast<float>()),
        view_(view) {}

  void first_rays(int row) {
    for (int start = 0; start < view_.width; start += kLanes) {
      RayPacket packet;
      packet.count = static_cast<std::size_t>(std::min(kLanes, view_.width - start));
      std::array<Ray, kLanes> lanes;
      for (std::size_t i = 0; i < packet.count; ++i) {
        const int column = start + static_cast<int>(i);
        lanes[i] = {origin_, R_ * rays_.direction(row, column), R_ * rays_.d_column(row, column),
                    R_ * rays_.d_row(row, column)};
        fill(packet, i, lanes[i].direction);
      }
      std::array<Hit, kLanes> hits;
      world_.closest(origin_, packet, true, hits.data());
      for (std::size_t i = 0; i < packet.count; ++i) {
        const Seen seen = world_.look(lanes[i], hits[i], 1.0F);
        const std::size_t at = view_.index(row, start + static_cast<int>(i));
        view_.radiance[at] = seen.radiance;
        view_.distance[at] = seen.distance;
        view_.surface[at] = seen.surface;
        view_.instance[at] = seen.instance;
      }
    }
  }

  /// Means of finer rays for the edge pixels of a row; two pixels fill a packet.
  void edges(int row, std::vector<float>& smooth) const {
    std::array<int, 2> columns{};
    std::size_t waiting = 0;
    for (int column = 0; column < view_.width; ++column) {
      if (!is_edge(row, column)) continue;
      columns[waiting++] = column;
      if (waiting == columns.size()) {
        refine(row, columns.data(), waiting, smooth);
        waiting = 0;
      }
    }
    if (waiting > 0) refine(row, columns.data(), waiting, smooth);
  }

 private:
  static void fill(RayPacket& packet, std::size_t lane, const Vector3f& direction) {
    packet.x[lane] = direction.x();
    packet.y[lane] = direction.y();
    packet.z[lane] = direction.z();
  }

  bool is_edge(int row, int column) const {
    const std::uint32_t here = view_.surface[view_.index(row, column)];
    const auto differs = [&](int r, int c) {
      return r >= 0 && c >= 0 && r < view_.height && c < view_.width &&
             view_.surface[view_.index(r, c)] != here;
    };
    return differs(row, column - 1) || differs(row, column + 1) || differs(row - 1, column) ||
           differs(row + 1, column);
  }

  void refine(int row, const int* columns, std::size_t count, std::vector<float>& smooth) const {
    RayPacket packet;
    packet.count = count * kSubRays;
    std::array<Ray, kLanes> lanes;
    for (std::size_t i = 0; i < packet.count; ++i) {
      const int column = columns[i / kSubRays];
      const float* offset = kOffsets[i % kSubRays];
      const Vector3f d_column = R_ * rays_.d_column(row, column);
      const Vector3f d_row = R_ * rays_.d_row(row, column);
      const Vector3f direction = R_ * rays_.direction(row, column) + offset[0] * d_column +
                                 offset[1] * d_row;
      lanes[i] = {origin_, direction.normalized(), d_column, d_row};
      fill(packet, i, lanes[i].direction);
    }
    std::array<Hit, kLanes> hits;
    world_.closest(origin_, packet, true, hits.data());
    for (std::size_t k = 0; k < count; ++k) {
      float sum = 0.0F;
      for (std::size_t i = k * kSubRays; i < (k + 1) * kSubRays; ++i) {
        sum += world_.look(lanes[i], hits[i], 0.5F).radiance;
      }
      smooth[view_.index(row, columns[k])] = sum / kSubRays;
    }
  }

  const World& world_;
  const RayTable& rays_;
  Eigen::Matrix3f R_;
  Vector3f origin_;
  View& view_;
};

}  // namespace

RayTable::RayTable(const Lens& lens) : width_(lens.width()), height_(lens.height()) {
  const auto rows = static_cast<std::size_t>(height_ + 2);
  const auto columns = static_cast<std::size_t>(width_ + 2);
  directions_.resize(rows * columns);
  parallel_for(rows, [&](std::size_t row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const Eigen::Vector2d pixel(static_cast<double>(column) - 1.0, static_cast<double>(row) - 1.0);
      directions_[row * columns + column] = lens.direction(pixel).cast<float>();
    }
  });
}

void render_view(const World& world,
                 const RayTable& rays,
                 const lie::SE3d& T_world_camera,
                 bool antialias,
                 View& view) {
  view.width = rays.width();
  view.height = rays.height();
  const auto rows = static_cast<std::size_t>(view.height);
  const std::size_t count = rows * static_cast<std::size_t>(view.width);
  view.radiance.resize(count);
  view.distance.resize(count);
  view.surface.resize(count);
  view.instance.resize(count);
  Pass pass(world, rays, T_world_camera, view);
  parallel_for(rows, [&](std::size_t row) { pass.first_rays(static_cast<int>(row)); });
  if (!antialias) return;
  std::vector<float> smooth = view.radiance;
  parallel_for(rows, [&](std::size_t row) { pass.edges(static_cast<int>(row), smooth); });
  view.radiance.swap(smooth);
}

}  // namespace imslam::simulation

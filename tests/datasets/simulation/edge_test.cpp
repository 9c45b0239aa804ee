// Does antialiasing with few rays, some of them shared by the pixels about a corner, leave edges
// where they are?
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "datasets/simulation/view.hpp"

namespace imslam::simulation {
namespace {

constexpr double kDark = 51.0 / 255.0;
constexpr double kBright = 204.0 / 255.0;
constexpr double kBand = 2.5;  ///< [px] from the edge; beyond it nothing is mixed
constexpr int kSize = 64;      ///< [px] of the image
constexpr int kMargin = 6;     ///< [px]
constexpr double kFocal = 200.0;
constexpr double kDepth = 5.0;  ///< [m]

const Lens& lens() {
  constexpr double kMiddle = 0.5 * (kSize - 1);
  static const Lens lens(Distortion::kRadTan, kSize, kSize, {kFocal, kFocal, kMiddle, kMiddle}, {});
  return lens;
}

/// A straight edge through the image: bright where normal . (pixel - middle) > offset_px.
struct Edge {
  double angle_deg = 0.0;  ///< of the normal, from right towards down
  double offset_px = 0.0;

  Eigen::Vector2d normal() const {
    const double angle = angle_deg * M_PI / 180.0;
    return {std::cos(angle), std::sin(angle)};
  }
  double distance_px(int row, int column) const {
    const Eigen::Vector2d middle = lens().intrinsics().tail<2>();
    return normal().dot(Eigen::Vector2d(column, row) - middle) - offset_px;
  }
};

/// A bright sheet with that edge in front of a dark wall; the camera sits in the origin.
Scene scene_of(const Edge& edge) {
  Scene scene;
  for (const int grey : {51, 204})
    scene.textures.emplace_back(2, std::vector<std::uint8_t>(4, static_cast<std::uint8_t>(grey)));
  scene.lighting.ambient = 1.0F;
  scene.lighting.ambient_reach_m = 1e-3F;  // nothing shades anything
  Paint dark;
  Paint bright;
  bright.texture = 1;
  const double cell_m = 1e3;
  scene.fixed.add_quad({-10.0, 10.0, kDepth + 1.0}, {20.0, 0.0, 0.0}, {0.0, -20.0, 0.0}, dark,
                       cell_m);
  const Eigen::Vector3d normal(edge.normal().x(), edge.normal().y(), 0.0);
  const Eigen::Vector3d along(normal.y(), -normal.x(), 0.0);
  const Eigen::Vector3d on_edge =
      edge.offset_px * kDepth / kFocal * normal + kDepth * Eigen::Vector3d::UnitZ();
  scene.fixed.add_quad(on_edge - 10.0 * along, 20.0 * normal, 20.0 * along, bright, cell_m);
  return scene;
}

/// Mean of 8 x 8 rays over the pixel.
double brute_force(const World& world, int row, int column) {
  constexpr int kRaster = 8;
  double sum = 0.0;
  for (int first = 0; first < kRaster * kRaster; first += static_cast<int>(kLanes)) {
    RayPacket rays;
    rays.count = kLanes;
    for (std::size_t i = 0; i < kLanes; ++i) {
      const int at = first + static_cast<int>(i);
      const Eigen::Vector2d within((at % kRaster + 0.5) / kRaster - 0.5,
                                   (at / kRaster + 0.5) / kRaster - 0.5);
      const Eigen::Vector3f direction =
          lens().direction(Eigen::Vector2d(column, row) + within).cast<float>();
      rays.direction.x[i] = direction.x();
      rays.direction.y[i] = direction.y();
      rays.direction.z[i] = direction.z();
    }
    std::array<Hit, kLanes> hits;
    SeenPacket seen;
    world.closest(Eigen::Vector3f::Zero(), rays, true, hits.data());
    world.look(Eigen::Vector3f::Zero(), rays, hits.data(), 0.125F, seen);
    for (std::size_t i = 0; i < kLanes; ++i) sum += static_cast<double>(seen.radiance[i]);
  }
  return sum / (kRaster * kRaster);
}

/// How an antialiased edge differs from the brute-force one.
struct EdgeError {
  double shift_px = 0.0;     ///< along the normal, mean over the edge
  double line_rms_px = 0.0;  ///< of the shift of single rows or columns
  double mean_grey = 0.0;    ///< over the pixels of the band, 1 = white
  double mean_absolute = 0.0;
};

EdgeError error_of(const Edge& edge) {
  const World world(scene_of(edge), Random(1));
  View view;
  render_view(world, RayTable(lens()), lie::SE3d(), true, view);
  const Eigen::Vector2d normal = edge.normal();
  const bool by_rows = std::abs(normal.x()) >= std::abs(normal.y());
  const double tilt = std::max(std::abs(normal.x()), std::abs(normal.y()));
  EdgeError error;
  int pixels = 0;
  for (int line = kMargin; line < kSize - kMargin; ++line) {
    double missing = 0.0;  // what the line lacks in bright pixels: its edge lies further on
    for (int i = 0; i < kSize; ++i) {
      const int row = by_rows ? line : i;
      const int column = by_rows ? i : line;
      if (std::abs(edge.distance_px(row, column)) > kBand) continue;
      const double grey = static_cast<double>(view.radiance[view.index(row, column)]);
      const double difference = grey - brute_force(world, row, column);
      missing -= difference / (kBright - kDark);
      error.mean_grey += difference;
      error.mean_absolute += std::abs(difference);
      ++pixels;
    }
    error.shift_px += tilt * missing / (kSize - 2 * kMargin);
    error.line_rms_px += tilt * tilt * missing * missing / (kSize - 2 * kMargin);
  }
  error.line_rms_px = std::sqrt(error.line_rms_px);
  error.mean_grey /= pixels;
  error.mean_absolute /= pixels;
  return error;
}

EdgeError mean_over_offsets(double angle_deg) {
  constexpr int kOffsets = 37;
  constexpr double kPeriod = 4.0;  // [px] of the renderer's tiles
  EdgeError mean;
  for (int k = 0; k < kOffsets; ++k) {
    const EdgeError error = error_of({angle_deg, kPeriod * ((k + 0.5) / kOffsets - 0.5)});
    mean.shift_px += error.shift_px / kOffsets;
    mean.line_rms_px += error.line_rms_px / kOffsets;
    mean.mean_grey += error.mean_grey / kOffsets;
    mean.mean_absolute += error.mean_absolute / kOffsets;
  }
  return mean;
}

TEST(Edge, AntialiasedStraightEdgesStayWhereSixtyFourRaysPutThem) {
  for (const double angle_deg : {0.0, 3.0, 10.0, 27.0, 45.0, 63.0, 90.0, 117.0, 135.0, 153.0, 180.0,
                                 207.0, 225.0, 270.0, 315.0}) {
    const EdgeError error = mean_over_offsets(angle_deg);
    RecordProperty(
        fmt::format("edge_at_{}_deg", angle_deg),
        fmt::format("shift {:.4f} px, rms of a line {:.4f} px, grey {:.5f}, |grey| {:.5f}",
                    error.shift_px, error.line_rms_px, error.mean_grey, error.mean_absolute));
    EXPECT_LT(std::abs(error.shift_px), 0.01) << angle_deg;
    EXPECT_LT(error.line_rms_px, 0.2) << angle_deg;
    EXPECT_LT(std::abs(error.mean_grey), 0.01) << angle_deg;
    EXPECT_LT(error.mean_absolute, 0.025) << angle_deg;
  }
}

}  // namespace
}  // namespace imslam::simulation

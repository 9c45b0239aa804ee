#include <algorithm>
#include <cmath>

#include "datasets/simulation/view.hpp"
#include "slam/base/parallel.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kMostTaps = 40;
constexpr float kShortest = 0.25F;  ///< [px] less blur than this is not worth a tap

/// Linear motion of a point field: velocity at p is v + omega x p, in the camera frame.
struct Twist {
  Vector3f v = Vector3f::Zero();
  Vector3f omega = Vector3f::Zero();
};

/// How the points of each instance move as seen from the camera.
std::vector<Twist> instance_twists(const World& world, const CameraMotion& motion, double time_s) {
  const Twist still{-motion.v_camera.cast<float>(), -motion.omega_camera.cast<float>()};
  std::vector<Twist> twists(world.scene().instances.size() + 1, still);
  constexpr double kStep = 1e-3;
  const lie::SE3d T_camera_world = motion.T_world_camera.inverse();
  for (std::uint32_t i = 1; i < twists.size(); ++i) {
    if (!world.moves(i)) continue;
    const lie::SE3d step = world.instance_motion(i, time_s - kStep, time_s + kStep);
    const lie::SE3d::Tangent in_camera =
        (T_camera_world * step * motion.T_world_camera).log() / (2.0 * kStep);
    twists[i].v += in_camera.head<3>().cast<float>();
    twists[i].omega += in_camera.tail<3>().cast<float>();
  }
  return twists;
}

[[gnu::always_inline]] inline Floats clamped(const Floats& value, float high) {
  const Floats positive = value > 0.0F ? value : Floats{};
  return positive < high ? positive : Floats{} + high;
}

[[gnu::always_inline]] inline Floats read(const float* from, const Ints& index) {
  std::int32_t at[kLanes];
  float values[kLanes];
  std::memcpy(at, &index, sizeof at);
  for (std::size_t i = 0; i < kLanes; ++i) values[i] = from[at[i]];
  Floats lanes;
  std::memcpy(&lanes, values, sizeof lanes);
  return lanes;
}

[[gnu::always_inline]] inline Floats bilinear(const View& view,
                                              const Floats& column,
                                              const Floats& row) {
  const Floats x = clamped(column, static_cast<float>(view.width - 1));
  const Floats y = clamped(row, static_cast<float>(view.height - 1));
  Ints x0 = __builtin_convertvector(x, Ints);
  Ints y0 = __builtin_convertvector(y, Ints);
  x0 = x0 < view.width - 2 ? x0 : Ints{} + (view.width - 2);
  y0 = y0 < view.height - 2 ? y0 : Ints{} + (view.height - 2);
  const Floats fx = x - __builtin_convertvector(x0, Floats);
  const Floats fy = y - __builtin_convertvector(y0, Floats);
  const Ints at = y0 * view.width + x0;
  const float* top = view.radiance.data();
  const float* bottom = top + view.width;
  const Floats upper_left = read(top, at);
  const Floats lower_left = read(bottom, at);
  const Floats upper = upper_left + fx * (read(top + 1, at) - upper_left);
  const Floats lower = lower_left + fx * (read(bottom + 1, at) - lower_left);
  return upper + fy * (lower - upper);
}

/// How the pixels of a tile move, and where they are.
struct TileMotion {
  Floats3 v, omega;
  Floats nearness;     ///< one over the distance [1/m]; 0 for the sky
  Floats column, row;  ///< [px]
};

TileMotion tile_motion(const View& view,
                       const std::vector<Twist>& twists,
                       int tile_row,
                       int tile_column) {
  TileMotion motion;
  const auto put = [](Floats3& lanes, std::size_t i, const Vector3f& value) {
    lanes.x[i] = value.x();
    lanes.y[i] = value.y();
    lanes.z[i] = value.z();
  };
  for (std::size_t i = 0; i < kLanes; ++i) {
    const int row = std::min(tile_row * RayTable::kTile + static_cast<int>(i) / RayTable::kTile,
                             view.height - 1);
    const int column = std::min(
        tile_column * RayTable::kTile + static_cast<int>(i) % RayTable::kTile, view.width - 1);
    const std::size_t at = view.index(row, column);
    const Twist& twist = twists[view.instance[at]];
    put(motion.v, i, twist.v);
    put(motion.omega, i, twist.omega);
    motion.nearness[i] = 1.0F / view.distance[at];
    motion.column[i] = static_cast<float>(column);
    motion.row[i] = static_cast<float>(row);
  }
  return motion;
}

}  // namespace

/// Mean radiance along each pixel's segment of the image, centred on the pixel.
IMSLAM_FOR_EACH_PROCESSOR void smear(const View& view,
                                     const RayTable::Tile& rays,
                                     const RayTable::PixelChange& J,
                                     const TileMotion& motion,
                                     float exposure_s,
                                     Floats& result) {
  const Floats3& d = rays.direction;
  const Floats3& omega = motion.omega;
  const Floats3 d_rate{omega.y * d.z - omega.z * d.y + motion.nearness * motion.v.x,
                       omega.z * d.x - omega.x * d.z + motion.nearness * motion.v.y,
                       omega.x * d.y - omega.y * d.x + motion.nearness * motion.v.z};
  const Floats columns =
      exposure_s * (J.column.x * d_rate.x + J.column.y * d_rate.y + J.column.z * d_rate.z);
  const Floats rows = exposure_s * (J.row.x * d_rate.x + J.row.y * d_rate.y + J.row.z * d_rate.z);
  const Floats length_sq = columns * columns + rows * rows;
  Ints taps;
  int most_taps = 1;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float length = std::sqrt(std::min(length_sq[i], kMostTaps * kMostTaps * 1.0F));
    // Without blur the single tap is the pixel itself.
    taps[i] = length > kShortest ? std::min(kMostTaps, static_cast<int>(std::ceil(length)) + 1) : 1;
    most_taps = std::max(most_taps, int{taps[i]});
  }
  const Floats count = __builtin_convertvector(taps, Floats);
  const Floats column_step = columns / count;
  const Floats row_step = rows / count;
  const Floats first = -0.5F * (count - 1.0F);
  Floats x = motion.column + first * column_step;
  Floats y = motion.row + first * row_step;
  Floats sum = {};
  for (int k = 0; k < most_taps; ++k) {
    const Floats value = bilinear(view, x, y);
    sum += taps > k ? value : Floats{};
    x += column_step;
    y += row_step;
  }
  result = sum / count;
}

CameraMotion camera_motion(const MotionState& body, const lie::SE3d& T_body_camera) {
  CameraMotion motion;
  motion.T_world_camera = body.T_world_body * T_body_camera;
  const lie::SO3d R_camera_body = T_body_camera.rotation().inverse();
  const Eigen::Vector3d v_body = body.T_world_body.rotation().inverse() * body.v_world +
                                 body.omega_body.cross(T_body_camera.translation());
  motion.v_camera = R_camera_body * v_body;
  motion.omega_camera = R_camera_body * body.omega_body;
  return motion;
}

std::vector<float> blur_motion(const View& view,
                               const World& world,
                               const RayTable& rays,
                               const CameraMotion& motion,
                               double time_s,
                               double exposure_s) {
  std::vector<float> result(view.radiance.size());
  const std::vector<Twist> twists = instance_twists(world, motion, time_s);
  const auto exposure = static_cast<float>(exposure_s);
  parallel_for(static_cast<std::size_t>(rays.tile_rows()), [&](std::size_t at_tile_row) {
    const int tile_row = static_cast<int>(at_tile_row);
    for (int tile_column = 0; tile_column < rays.tile_columns(); ++tile_column) {
      const TileMotion moving = tile_motion(view, twists, tile_row, tile_column);
      Floats mean;
      smear(view, rays.tile(tile_row, tile_column), rays.pixel_change(tile_row, tile_column),
            moving, exposure, mean);
      for (std::size_t i = 0; i < kLanes; ++i) {
        const int row = tile_row * RayTable::kTile + static_cast<int>(i) / RayTable::kTile;
        const int column = tile_column * RayTable::kTile + static_cast<int>(i) % RayTable::kTile;
        if (row < view.height && column < view.width) result[view.index(row, column)] = mean[i];
      }
    }
  });
  return result;
}

}  // namespace imslam::simulation

#include <algorithm>
#include <cmath>

#include "datasets/simulation/view.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int kMostTaps = 40;
constexpr float kShortest = 0.25F;  ///< [px] less blur than this is not worth a tap

float bilinear(const View& view, float column, float row) {
  const float x = std::clamp(column, 0.0F, static_cast<float>(view.width - 1));
  const float y = std::clamp(row, 0.0F, static_cast<float>(view.height - 1));
  const int x0 = std::min(static_cast<int>(x), view.width - 2);
  const int y0 = std::min(static_cast<int>(y), view.height - 2);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const float* top = &view.radiance[view.index(y0, x0)];
  const float* bottom = top + view.width;
  const float upper = top[0] + fx * (top[1] - top[0]);
  const float lower = bottom[0] + fx * (bottom[1] - bottom[0]);
  return upper + fy * (lower - upper);
}

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
    const auto in_camera = (T_camera_world * step * motion.T_world_camera).log() / (2.0 * kStep);
    twists[i].v += in_camera.head<3>().cast<float>();
    twists[i].omega += in_camera.tail<3>().cast<float>();
  }
  return twists;
}

/// Mean radiance along a segment of the image, centred on a pixel.
float smeared(const View& view, int column, int row, const Vector2f& smear, float length) {
  const int taps = std::min(kMostTaps, static_cast<int>(std::ceil(length)) + 1);
  const Vector2f step = smear / static_cast<float>(taps);
  const float first = -0.5F * static_cast<float>(taps - 1);
  float x = static_cast<float>(column) + first * step.x();
  float y = static_cast<float>(row) + first * step.y();
  float sum = 0.0F;
  for (int k = 0; k < taps; ++k) {
    sum += bilinear(view, x, y);
    x += step.x();
    y += step.y();
  }
  return sum / static_cast<float>(taps);
}

}  // namespace

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
  parallel_for(static_cast<std::size_t>(view.height), [&](std::size_t at_row) {
    const int row = static_cast<int>(at_row);
    for (int column = 0; column < view.width; ++column) {
      const std::size_t at = view.index(row, column);
      const Twist& twist = twists[view.instance[at]];
      const float nearness = 1.0F / view.distance[at];  // 0 for the sky
      const Vector3f d_rate = twist.omega.cross(rays.direction(row, column)) + nearness * twist.v;
      const Vector2f smear = exposure * (rays.J_pixel_direction(row, column) * d_rate);
      const float length = smear.norm();
      result[at] =
          length > kShortest ? smeared(view, column, row, smear, length) : view.radiance[at];
    }
  });
  return result;
}

}  // namespace imslam::simulation

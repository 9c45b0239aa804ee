#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"
#include "slam/sensors/stereo.hpp"

namespace imslam::testing {

/// A small camera for images that are quick to draw; the body is turned against it.
inline StereoCamera small_camera() {
  StereoCamera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 240.0;
  camera.cx = 158.0;
  camera.cy = 121.0;
  camera.baseline_m = 0.12;
  camera.T_body_left = lie::SE3d(lie::SO3d::exp(Eigen::Vector3d(0.2, -1.1, 0.7)),
                                 Eigen::Vector3d(0.03, -0.05, 0.02));
  return camera;
}

/// Grey values over the plane, smooth to second order: random knots, cubic B-spline between them.
class SplineTexture {
 public:
  SplineTexture(Random& random, double knot_distance_m) : distance_(knot_distance_m) {
    for (float& knot : knots_) knot = static_cast<float>(random.uniform(-60.0, 315.0));
  }

  double at(double x, double y) const {
    const double s = x / distance_;
    const double t = y / distance_;
    const double s0 = std::floor(s);
    const double t0 = std::floor(t);
    double wx[4];
    double wy[4];
    weights(s - s0, wx);
    weights(t - t0, wy);
    double value = 0.0;
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) {
        const auto column = static_cast<std::size_t>(static_cast<std::int64_t>(s0) + i) % kSize;
        const auto row = static_cast<std::size_t>(static_cast<std::int64_t>(t0) + j) % kSize;
        value += wx[i] * wy[j] * static_cast<double>(knots_[row * kSize + column]);
      }
    }
    return value;
  }

 private:
  static constexpr std::size_t kSize = 256;  // a power of two: the texture repeats, also below 0

  static void weights(double f, double* w) {
    const double g = 1.0 - f;
    w[0] = g * g * g / 6.0;
    w[1] = (3.0 * f * f * f - 6.0 * f * f + 4.0) / 6.0;
    w[2] = (3.0 * g * g * g - 6.0 * g * g + 4.0) / 6.0;
    w[3] = f * f * f / 6.0;
  }

  double distance_;
  std::vector<float> knots_ = std::vector<float>(kSize * kSize);
};

/// A textured plane in the world, tilted so that it is 2 to 5 m away from a camera at the origin.
class PlaneWorld {
 public:
  explicit PlaneWorld(std::uint64_t seed) : random_(seed), texture_(random_, 0.09) {}

  /// Depth along the ray of left pixel (u, v), seen from T_world_left.
  double depth(const StereoCamera& camera,
               const lie::SE3d& T_world_left,
               double u,
               double v) const {
    const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
    const Eigen::Vector3d direction = T_world_left.rotation() * ray;
    return (kDistance - normal().dot(T_world_left.translation())) / normal().dot(direction);
  }

  StereoFrame draw(const StereoCamera& camera,
                   const lie::SE3d& T_world_left,
                   std::int64_t time_ns,
                   double gain = 1.0) const {
    StereoFrame frame;
    frame.time_ns = time_ns;
    frame.left = draw_one(camera, T_world_left, gain);
    const lie::SE3d T_left_right(lie::SO3d(), Eigen::Vector3d(camera.baseline_m, 0.0, 0.0));
    frame.right = draw_one(camera, T_world_left * T_left_right, gain);
    return frame;
  }

 private:
  static constexpr double kDistance = 3.0;  // [m]
  static Eigen::Vector3d normal() { return Eigen::Vector3d(0.35, 0.25, 1.0).normalized(); }

  GrayImage draw_one(const StereoCamera& camera, const lie::SE3d& T_world_eye, double gain) const {
    GrayImage image;
    image.width = camera.width;
    image.height = camera.height;
    image.pixels.reserve(static_cast<std::size_t>(camera.width * camera.height));
    const Eigen::Vector3d ex = normal().unitOrthogonal();
    const Eigen::Vector3d ey = normal().cross(ex);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const double z = depth(camera, T_world_eye, u, v);
        const Eigen::Vector3d p = T_world_eye * Eigen::Vector3d((u - camera.cx) / camera.fx * z,
                                                                (v - camera.cy) / camera.fy * z, z);
        const double value = gain * texture_.at(ex.dot(p), ey.dot(p));
        image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
      }
    }
    return image;
  }

  Random random_;
  SplineTexture texture_;
};

inline GrayImage uniform_image(const StereoCamera& camera, std::uint8_t value) {
  return {camera.width, camera.height,
          std::vector<std::uint8_t>(static_cast<std::size_t>(camera.width * camera.height), value)};
}

inline GrayImage noise_image(const StereoCamera& camera, Random& random) {
  GrayImage image = uniform_image(camera, 0);
  for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(random.integer(0, 255));
  return image;
}

/// A gentle curve through the plane world, 20 frames/s.
inline lie::SE3d pose_of_frame(int index) {
  const double t = 0.05 * index;
  return lie::SE3d(lie::SO3d::exp(Eigen::Vector3d(0.05 * std::sin(2.0 * t), 0.2 * t, 0.1 * t)),
                   Eigen::Vector3d(0.4 * t, 0.1 * std::sin(3.0 * t), 0.3 * t));
}
inline std::int64_t time_of_frame(int index) { return 1'000'000'000 + 50'000'000LL * index; }

}  // namespace imslam::testing

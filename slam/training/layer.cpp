#include "slam/training/layer.hpp"

#include <algorithm>

namespace imslam::training {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d intrinsic_matrix(const StereoCamera& camera) {
  Matrix3d K;
  K << camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0;
  return K;
}

/// A covector on rays as a covector on pixels: f . K^-1 x.
Vector3d on_pixels(const Vector3d& f, const StereoCamera& camera) {
  const double u = f.x() / camera.fx;
  const double v = f.y() / camera.fy;
  return {u, v, f.z() - u * camera.cx - v * camera.cy};
}

void enclose_cut_out(const Layer& layer,
                     const StereoCamera& camera,
                     const lie::SE3d& T_camera_left0,
                     LayerImage& image) {
  const Vector3d half_s = layer.axis_s / layer.axis_s.squaredNorm();
  const Vector3d half_t = layer.axis_t / layer.axis_t.squaredNorm();
  constexpr double kNearest_m = 1e-3;
  LayerImage box;
  std::swap(box.left, box.right);
  std::swap(box.top, box.bottom);
  for (const double s : {-1.0, 1.0}) {
    for (const double t : {-1.0, 1.0}) {
      const Vector3d corner = T_camera_left0 * Vector3d(layer.origin + s * half_s + t * half_t);
      if (corner.z() < kNearest_m) return;  // reaches behind the camera: may be seen anywhere
      const Vector3d pixel = camera.project(corner);
      box.left = std::min(box.left, pixel.x());
      box.right = std::max(box.right, pixel.x());
      box.top = std::min(box.top, pixel.y());
      box.bottom = std::max(box.bottom, pixel.y());
    }
  }
  image.left = box.left;
  image.right = box.right;
  image.top = box.top;
  image.bottom = box.bottom;
}

}  // namespace

LayerImage project_layer(const Layer& layer,
                         const StereoCamera& camera,
                         const lie::SE3d& T_camera_left0) {
  const Matrix3d R = T_camera_left0.rotation().matrix();
  const Vector3d t = T_camera_left0.translation();
  // X' = R X + t, so n . X = 1 becomes (R n) . X' = 1 + (R n) . t.
  const Vector3d rotated = R * layer.plane;
  const Vector3d plane = rotated / (1.0 + rotated.dot(t));
  // a . (X - origin) + c = (R a) . X' + constant, and 1 = plane . X' on the plane.
  const auto moved = [&](const Vector3d& axis, double offset) -> Vector3d {
    const Vector3d a = R * axis;
    return on_pixels(a + (offset - a.dot(t) - axis.dot(layer.origin)) * plane, camera);
  };
  LayerImage image;
  image.inverse_depth = on_pixels(plane, camera);
  image.s = moved(layer.axis_s, 0.0);
  image.t = moved(layer.axis_t, 0.0);
  image.tile_u = moved(layer.tile_axis_u, layer.tile_offset.x());
  image.tile_v = moved(layer.tile_axis_v, layer.tile_offset.y());
  if (layer.shape != Layer::kEndless) enclose_cut_out(layer, camera, T_camera_left0, image);
  return image;
}

Eigen::Matrix3d layer_homography(const Layer& layer,
                                 const StereoCamera& camera,
                                 const lie::SE3d& T_camera_left0) {
  const Matrix3d K = intrinsic_matrix(camera);
  const Matrix3d R = T_camera_left0.rotation().matrix();
  return K * (R + T_camera_left0.translation() * layer.plane.transpose()) * K.inverse();
}

}  // namespace imslam::training

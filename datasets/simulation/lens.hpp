#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

namespace imslam::simulation {

enum class Distortion { kRadTan, kEquidistant };

/// A pinhole camera behind a distorting lens. Integer pixel coordinates are pixel centres, as in
/// OpenCV.
///
///   m = [x/z y/z],  m' = distort(m),  u = fx m'_x + cx,  v = fy m'_y + cy
///   radtan        coefficients k1 k2 p1 p2 (OpenCV's projectPoints)
///   equidistant   coefficients k1 k2 k3 k4 of theta_d = theta (1 + k1 theta^2 + ...)
///                 (OpenCV's fisheye; Kannala and Brandt, PAMI 2006)
class Lens {
 public:
  Lens() = default;
  Lens(Distortion model,
       int width,
       int height,
       const Eigen::Vector4d& intrinsics,
       const std::array<double, 4>& coefficients);

  /// The pixel [px] of a point [m] in the camera frame; empty where the lens model has no answer
  /// (behind the camera, or beyond the radius at which the distortion folds back).
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_camera) const;

  /// Unit vector along the ray of a pixel; inverse of project().
  Eigen::Vector3d direction(const Eigen::Vector2d& pixel) const;

  bool contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width_ - 0.5 &&
           pixel.y() < height_ - 0.5;
  }

  Distortion model() const { return model_; }
  int width() const { return width_; }
  int height() const { return height_; }
  const Eigen::Vector4d& intrinsics() const { return intrinsics_; }  ///< fx fy cx cy [px]
  const std::array<double, 4>& coefficients() const { return coefficients_; }

 private:
  Eigen::Vector2d distort_radtan(const Eigen::Vector2d& m, Eigen::Matrix2d* J_y_m = nullptr) const;
  Eigen::Vector3d undistort_radtan(const Eigen::Vector2d& distorted) const;
  Eigen::Vector3d undistort_equidistant(const Eigen::Vector2d& distorted) const;
  double distorted_angle(double theta, double* derivative = nullptr) const;

  Distortion model_ = Distortion::kRadTan;
  int width_ = 0;
  int height_ = 0;
  Eigen::Vector4d intrinsics_ = Eigen::Vector4d::Ones();
  std::array<double, 4> coefficients_{};
  double fold_radius_sq_ = 0.0;  ///< of m; beyond it the radial polynomial decreases
};

/// "radial-tangential" or "equidistant", the names used in ASL sensor.yaml files.
std::string distortion_name(Distortion model);

}  // namespace imslam::simulation

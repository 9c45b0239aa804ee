#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "slam/lie/se3.hpp"

namespace imslam::datasets {

enum class LensModel {
  kNone,              ///< already free of distortion
  kRadialTangential,  ///< OpenCV [k1 k2 p1 p2 (k3 (k4 k5 k6))]
  kEquidistant,       ///< Kannala-Brandt fisheye [k1 k2 k3 k4]
};

/// A camera as calibrated, before rectification.
struct RawCamera {
  int width = 0;    ///< [px]
  int height = 0;   ///< [px]
  double fx = 0.0;  ///< [px]
  double fy = 0.0;  ///< [px]
  double cx = 0.0;  ///< [px]
  double cy = 0.0;  ///< [px]
  LensModel lens = LensModel::kNone;
  std::vector<double> distortion;
  lie::SE3d T_body_camera;
  std::string where;            ///< "file:line", for messages
  std::string where_it_stands;  ///< likewise, of T_body_camera; empty: as `where`
};

/// "radial-tangential", "radtan", "plumb_bob", "equidistant", "none".
/// InputError(kCalibration) for any other name.
LensModel lens_model(const std::string& name, const std::string& where);

/// InputError(kCalibration) naming the value if size, focal length, principal point or the number
/// of distortion coefficients is impossible.
void validate(const RawCamera& camera);

/// A rigid motion from a matrix in a file. InputError(kCalibration) if it is no rotation:
/// |R^T R - I| > 1e-3, det < 0, last row other than 0 0 0 1, or a translation above 100 m.
lie::SE3d rigid_motion(const Eigen::Matrix4d& M, const std::string& where);

[[noreturn]] void fail_calibration(const std::string& where, const std::string& message);

}  // namespace imslam::datasets

#include "datasets/camera_model.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::datasets {
namespace {

constexpr double kMaxOrthonormalityError = 1e-3;
constexpr double kMaxTangential = 0.1;  // real lenses stay below 0.02
constexpr double kMaxLeverArm_m = 100.0;
constexpr int kMaxSide = 1 << 15;  // the fixed-point remap maps of OpenCV end here

bool coefficient_count_fits(const RawCamera& camera) {
  const std::size_t count = camera.distortion.size();
  switch (camera.lens) {
    case LensModel::kNone:
      return true;
    case LensModel::kRadialTangential:
      return count == 4 || count == 5 || count == 8;
    case LensModel::kEquidistant:
      break;
  }
  return count == 4;
}

void check_tangential(const RawCamera& camera) {
  if (camera.lens != LensModel::kRadialTangential) return;
  const double p = std::max(std::abs(camera.distortion[2]), std::abs(camera.distortion[3]));
  if (p > kMaxTangential) {
    fail_calibration(camera.where, fmt::format("tangential distortion of {:.3g} is impossible; the "
                                               "order of the coefficients is k1 k2 p1 p2 (k3 ...)",
                                               p));
  }
}

}  // namespace

void fail_calibration(const std::string& where, const std::string& message) {
  throw InputError(where + ": " + message, ExitCode::kCalibration);
}

LensModel lens_model(const std::string& name, const std::string& where) {
  if (name == "radial-tangential" || name == "radtan" || name == "plumb_bob") {
    return LensModel::kRadialTangential;
  }
  if (name == "equidistant" || name == "fisheye") return LensModel::kEquidistant;
  if (name == "none" || name.empty()) return LensModel::kNone;
  fail_calibration(where,
                   fmt::format("expected the distortion model radial-tangential (radtan), "
                               "equidistant or none, found '{}'; calibrate with one of these",
                               name));
}

void validate(const RawCamera& camera) {
  const std::string& where = camera.where;
  if (camera.width < 16 || camera.height < 16 || camera.width >= kMaxSide ||
      camera.height >= kMaxSide) {
    fail_calibration(where, fmt::format("expected an image size of 16 to {} px, found {}x{}",
                                        kMaxSide - 1, camera.width, camera.height));
  }
  const double side = std::max(camera.width, camera.height);
  for (const double f : {camera.fx, camera.fy}) {
    if (!(f > 0.05 * side && f < 100.0 * side)) {
      fail_calibration(where, fmt::format("focal length {} px does not fit an image of {}x{} px; "
                                          "intrinsics are fx, fy, cx, cy in px",
                                          f, camera.width, camera.height));
    }
  }
  if (std::abs(camera.fx / camera.fy - 1.0) > 0.5) {
    fail_calibration(where, fmt::format("focal lengths {} and {} px differ too much; intrinsics "
                                        "are fx, fy, cx, cy",
                                        camera.fx, camera.fy));
  }
  if (!(camera.cx > 0 && camera.cx < camera.width && camera.cy > 0 && camera.cy < camera.height)) {
    fail_calibration(where, fmt::format("principal point ({}, {}) lies outside of the image of "
                                        "{}x{} px; intrinsics are fx, fy, cx, cy",
                                        camera.cx, camera.cy, camera.width, camera.height));
  }
  if (!coefficient_count_fits(camera)) {
    fail_calibration(where, fmt::format("found {} distortion coefficients; radial-tangential has "
                                        "4, 5 or 8 (k1 k2 p1 p2 ...), equidistant 4",
                                        camera.distortion.size()));
  }
  check_tangential(camera);
}

lie::SE3d rigid_motion(const Eigen::Matrix4d& M, const std::string& where) {
  const Eigen::Matrix3d R = M.topLeftCorner<3, 3>();
  if (!M.allFinite()) fail_calibration(where, "expected finite numbers");
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > kMaxOrthonormalityError) {
    fail_calibration(where,
                     fmt::format("the 3x3 part is no rotation: R^T R differs from I by {:.2g}"
                                 " (limit {}); check the matrix",
                                 error, kMaxOrthonormalityError));
  }
  if (R.determinant() < 0.0) {
    fail_calibration(where,
                     "the 3x3 part is a mirror (determinant -1), not a rotation; an axis "
                     "has the wrong sign or two are exchanged");
  }
  const Eigen::RowVector4d last_row(0.0, 0.0, 0.0, 1.0);
  if ((M.row(3) - last_row).cwiseAbs().maxCoeff() > 1e-9) {
    fail_calibration(where, "the last row is not 0 0 0 1; is the matrix transposed?");
  }
  if (M.topRightCorner<3, 1>().norm() > kMaxLeverArm_m) {
    fail_calibration(where, fmt::format("translation of {:.4g} m between sensors; is it in "
                                        "millimetres? metres are expected",
                                        M.topRightCorner<3, 1>().norm()));
  }
  return lie::SE3d::from_matrix(M);
}

}  // namespace imslam::datasets

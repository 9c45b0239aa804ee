#include "datasets/rectify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "slam/base/error.hpp"

namespace imslam::datasets {
namespace {

constexpr double kMinBaseline_m = 1e-3;
constexpr double kMaxBaseline_m = 10.0;

cv::Matx33d camera_matrix(const RawCamera& camera) {
  return {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
}

cv::Mat distortion(const RawCamera& camera) {
  if (camera.lens == LensModel::kNone) return cv::Mat::zeros(4, 1, CV_64F);
  return cv::Mat(camera.distortion, true);
}

cv::Matx33d to_cv(const Eigen::Matrix3d& M) {
  return {M(0, 0), M(0, 1), M(0, 2), M(1, 0), M(1, 1), M(1, 2), M(2, 0), M(2, 1), M(2, 2)};
}

Eigen::Matrix3d to_eigen(const cv::Matx33d& M) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(M.val);
}

struct Rectification {
  cv::Matx33d R_left;   ///< rectified <- left
  cv::Matx33d R_right;  ///< rectified <- right
  cv::Matx34d P;        ///< projection of the rectified left camera
};

/// A pinhole image of a fisheye view, cut where it would stretch too much.
cv::Matx34d fisheye_projection(const RawCamera& camera) {
  const double f_side = 0.5 * camera.width / std::tan(StereoRectifier::kMaxHalfView);
  const double f = std::max(f_side, 0.5 * std::min(camera.fx, camera.fy));
  return {f,   0.0, 0.5 * (camera.width - 1), 0.0, 0.0, f, 0.5 * (camera.height - 1), 0.0, 0.0, 0.0,
          1.0, 0.0};
}

Rectification rectification(const RawCamera& left, const RawCamera& right) {
  const lie::SE3d T_right_left = right.T_body_camera.inverse() * left.T_body_camera;
  const cv::Matx33d R = to_cv(T_right_left.rotation().matrix());
  const Eigen::Vector3d t = T_right_left.translation();
  const cv::Vec3d T(t.x(), t.y(), t.z());
  const cv::Size size(left.width, left.height);
  Rectification result;
  cv::Matx34d P_right;
  cv::Matx44d Q;
  if (left.lens == LensModel::kEquidistant) {
    cv::fisheye::stereoRectify(camera_matrix(left), distortion(left), camera_matrix(right),
                               distortion(right), size, R, T, result.R_left, result.R_right,
                               result.P, P_right, Q, cv::CALIB_ZERO_DISPARITY, size);
    result.P = fisheye_projection(left);
  } else {
    cv::stereoRectify(camera_matrix(left), distortion(left), camera_matrix(right),
                      distortion(right), size, R, T, result.R_left, result.R_right, result.P,
                      P_right, Q, cv::CALIB_ZERO_DISPARITY, 0.0, size);
  }
  return result;
}

StereoCamera rectified_camera(const RawCamera& left,
                              const RawCamera& right,
                              const Rectification& rectified) {
  StereoCamera camera;
  camera.width = left.width;
  camera.height = left.height;
  camera.fx = rectified.P(0, 0);
  camera.fy = rectified.P(1, 1);
  camera.cx = rectified.P(0, 2);
  camera.cy = rectified.P(1, 2);
  camera.baseline_m = (right.T_body_camera.translation() - left.T_body_camera.translation()).norm();
  const lie::SO3d R_left_rectified = lie::SO3d::from_matrix(to_eigen(rectified.R_left).transpose());
  camera.T_body_left = left.T_body_camera * lie::SE3d(R_left_rectified, Eigen::Vector3d::Zero());
  return camera;
}

void check_pair(const RawCamera& left, const RawCamera& right) {
  if (left.width != right.width || left.height != right.height) {
    fail_calibration(right.where,
                     fmt::format("images of {}x{} px, but {}x{} px at {}; both must "
                                 "have one size",
                                 right.width, right.height, left.width, left.height, left.where));
  }
  const bool left_fisheye = left.lens == LensModel::kEquidistant;
  const bool right_fisheye = right.lens == LensModel::kEquidistant;
  if (left_fisheye != right_fisheye) {
    fail_calibration(right.where,
                     "one camera is equidistant, the other is not; calibrate both "
                     "with the same model");
  }
  if (stands_left_of(right, left)) {
    fail_calibration(right.where,
                     "the right camera stands to the left of the left one; the two "
                     "are exchanged");
  }
}

}  // namespace

struct StereoRectifier::Map {
  cv::Mat xy;  ///< CV_16SC2: fixed-point maps are remapped about twice as fast
  cv::Mat fraction;

  Map(const RawCamera& camera, const cv::Matx33d& R, const StereoCamera& target) {
    const cv::Matx33d P(target.fx, 0.0, target.cx, 0.0, target.fy, target.cy, 0.0, 0.0, 1.0);
    const cv::Size size(target.width, target.height);
    if (camera.lens == LensModel::kEquidistant) {
      cv::fisheye::initUndistortRectifyMap(camera_matrix(camera), distortion(camera), R, P, size,
                                           CV_16SC2, xy, fraction);
    } else {
      cv::initUndistortRectifyMap(camera_matrix(camera), distortion(camera), R, P, size, CV_16SC2,
                                  xy, fraction);
    }
  }
};

StereoRectifier::StereoRectifier(const RawCamera& left, const RawCamera& right) {
  validate(left);
  validate(right);
  check_pair(left, right);
  const Rectification rectified = rectification(left, right);
  camera_ = rectified_camera(left, right, rectified);
  if (!(camera_.fx > 0.05 * camera_.width && camera_.fx < 20.0 * camera_.width &&
        std::isfinite(camera_.cx + camera_.cy))) {
    fail_calibration(left.where, fmt::format("rectification gives a focal length of {:.4g} px for "
                                             "an image of {} px; check distortion coefficients "
                                             "and extrinsics of both cameras",
                                             camera_.fx, camera_.width));
  }
  left_map_ = std::make_unique<Map>(left, rectified.R_left, camera_);
  right_map_ = std::make_unique<Map>(right, rectified.R_right, camera_);
}

StereoRectifier::StereoRectifier(const StereoCamera& camera) : camera_(camera) {}
StereoRectifier::~StereoRectifier() = default;
StereoRectifier::StereoRectifier(StereoRectifier&&) noexcept = default;
StereoRectifier& StereoRectifier::operator=(StereoRectifier&&) noexcept = default;

GrayImage StereoRectifier::apply(const Map& map, GrayImage raw) const {
  expects(raw.width == camera_.width && raw.height == camera_.height,
          "StereoRectifier: image of another size");
  GrayImage result;
  result.width = camera_.width;
  result.height = camera_.height;
  result.pixels.resize(raw.pixels.size());
  const cv::Mat source(raw.height, raw.width, CV_8UC1, raw.pixels.data());
  cv::Mat target(result.height, result.width, CV_8UC1, result.pixels.data());
  cv::remap(source, target, map.xy, map.fraction, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return result;
}

GrayImage StereoRectifier::left(GrayImage raw) const {
  return raw.empty() || !left_map_ ? std::move(raw) : apply(*left_map_, std::move(raw));
}

GrayImage StereoRectifier::right(GrayImage raw) const {
  return raw.empty() || !right_map_ ? std::move(raw) : apply(*right_map_, std::move(raw));
}

bool stands_left_of(const RawCamera& b, const RawCamera& a) {
  const Eigen::Vector3d p_a = (a.T_body_camera.inverse() * b.T_body_camera).translation();
  const double baseline = p_a.norm();
  const std::string& where = b.where_it_stands.empty() ? b.where : b.where_it_stands;
  if (!(baseline >= kMinBaseline_m && baseline <= kMaxBaseline_m)) {
    fail_calibration(where, fmt::format("the cameras are {:.4g} m apart, expected {} to {} m; "
                                        "check the extrinsics (metres) of both",
                                        baseline, kMinBaseline_m, kMaxBaseline_m));
  }
  if (std::abs(p_a.x()) < 0.7 * baseline) {
    fail_calibration(
        where, fmt::format("the cameras do not stand side by side: the second is at ({:.3f}, "
                           "{:.3f}, {:.3f}) m (right, down, forward) of the first; are the "
                           "extrinsics inverted? They carry points from the camera to the body",
                           p_a.x(), p_a.y(), p_a.z()));
  }
  const double angle = (a.T_body_camera.inverse() * b.T_body_camera).rotation().log().norm();
  if (angle > 1.0) {
    fail_calibration(where, fmt::format("the cameras look {:.0f} degrees apart; stereo needs "
                                        "one view; check the extrinsics of both",
                                        angle * 57.29577951308232));
  }
  return p_a.x() < 0.0;
}

}  // namespace imslam::datasets

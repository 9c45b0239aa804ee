#include "datasets/visual_probe.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "slam/lie/so3.hpp"

namespace imslam::datasets {
namespace {

constexpr int kCorners = 200;
constexpr int kLevels = 5;  ///< of the pyramid: disparities of 100 px and more occur
constexpr int kMinInliers = 15;
constexpr double kMinDisparity = 0.5;  ///< [px] beyond it a point only tells rotation

const cv::Size kWindow(17, 17);
const cv::TermCriteria kStop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.005);

cv::Mat as_mat(const GrayImage& image) {
  return cv::Mat(image.height, image.width, CV_8UC1,
                 const_cast<std::uint8_t*>(image.pixels.data()));
}

cv::Point2f to_cv(const Eigen::Vector2d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}

}  // namespace

struct ProbePyramid {
  std::vector<cv::Mat> levels;

  explicit ProbePyramid(const GrayImage& image) {
    cv::buildOpticalFlowPyramid(as_mat(image), levels, kWindow, kLevels, true,
                                cv::BORDER_REFLECT_101, cv::BORDER_CONSTANT, false);
  }
};

namespace {

/// Points found there and back again within half a pixel; status per point.
std::vector<bool> flow_both_ways(const ProbePyramid& from,
                                 const ProbePyramid& to,
                                 const std::vector<cv::Point2f>& points,
                                 std::vector<cv::Point2f>& found) {
  std::vector<bool> good(points.size(), false);
  if (points.empty()) return good;
  std::vector<cv::Point2f> back;
  std::vector<std::uint8_t> there_ok;
  std::vector<std::uint8_t> back_ok;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(from.levels, to.levels, points, found, there_ok, error, kWindow, kLevels,
                           kStop);
  cv::calcOpticalFlowPyrLK(to.levels, from.levels, found, back, back_ok, error, kWindow, kLevels,
                           kStop);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Point2f miss = back[i] - points[i];
    good[i] = there_ok[i] != 0 && back_ok[i] != 0 && std::hypot(miss.x, miss.y) < 0.5F;
  }
  return good;
}

StereoMatches match(const GrayImage& left,
                    const ProbePyramid& left_pyramid,
                    const ProbePyramid& right_pyramid,
                    int max_corners) {
  StereoMatches matches;
  std::vector<cv::Point2f> corners;
  const double spacing = std::sqrt(static_cast<double>(left.width) * left.height / max_corners);
  cv::goodFeaturesToTrack(as_mat(left), corners, max_corners, 0.005, 0.6 * spacing);
  std::vector<cv::Point2f> found;
  const auto good = flow_both_ways(left_pyramid, right_pyramid, corners, found);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!good[i]) continue;
    matches.left.emplace_back(corners[i].x, corners[i].y);
    matches.right.emplace_back(found[i].x, found[i].y);
  }
  return matches;
}

}  // namespace

StereoMatches match_stereo(const GrayImage& left, const GrayImage& right, int max_corners) {
  if (left.empty() || right.empty()) return {};
  return match(left, ProbePyramid(left), ProbePyramid(right), max_corners);
}

VisualProbe::VisualProbe(const StereoCamera& camera) : camera_(camera) {}
VisualProbe::~VisualProbe() = default;

void VisualProbe::add(const StereoFrame& frame) {
  if (!frame.complete()) {
    pyramid_.reset();
    return;
  }
  auto pyramid = std::make_unique<ProbePyramid>(frame.left);
  if (pyramid_) track(*pyramid, frame.time_ns);
  matches_ = match(frame.left, *pyramid, ProbePyramid(frame.right), kCorners);
  for (std::size_t i = 0; i < matches_.left.size(); ++i) {
    disparities_.push_back(matches_.left[i].x() - matches_.right[i].x());
    row_differences_.push_back(matches_.left[i].y() - matches_.right[i].y());
  }
  pyramid_ = std::move(pyramid);
  time_ns_ = frame.time_ns;
}

void VisualProbe::track(const ProbePyramid& next, std::int64_t time_ns) {
  std::vector<cv::Point2f> before;
  std::vector<cv::Point3f> points;
  for (std::size_t i = 0; i < matches_.left.size(); ++i) {
    const Eigen::Vector2d& p = matches_.left[i];
    if (std::abs(p.y() - matches_.right[i].y()) > 2.0) continue;
    const double disparity = std::max(kMinDisparity, p.x() - matches_.right[i].x());
    const Eigen::Vector3d X = camera_.back_project({p.x(), p.y(), disparity});
    before.push_back(to_cv(p));
    points.emplace_back(static_cast<float>(X.x()), static_cast<float>(X.y()),
                        static_cast<float>(X.z()));
  }
  std::vector<cv::Point2f> after;
  const auto good = flow_both_ways(*pyramid_, next, before, after);
  std::vector<cv::Point3f> X;
  std::vector<cv::Point2f> x;
  for (std::size_t i = 0; i < good.size(); ++i) {
    if (good[i]) X.push_back(points[i]), x.push_back(after[i]);
  }
  if (static_cast<int>(X.size()) < kMinInliers) return;
  const cv::Matx33d K(camera_.fx, 0, camera_.cx, 0, camera_.fy, camera_.cy, 0, 0, 1);
  cv::Vec3d r(0, 0, 0);
  cv::Vec3d t(0, 0, 0);
  std::vector<int> inliers;
  const bool solved = cv::solvePnPRansac(X, x, K, cv::noArray(), r, t, true, 100, 1.5F, 0.99,
                                         inliers, cv::SOLVEPNP_ITERATIVE);
  if (!solved || static_cast<int>(inliers.size()) < kMinInliers) return;
  const lie::SO3d R_left1_left0 = lie::SO3d::exp(Eigen::Vector3d(r[0], r[1], r[2]));
  const Eigen::Vector3d t_left1_left0(t[0], t[1], t[2]);
  if (!t_left1_left0.allFinite()) return;
  VisualRotation rotation;
  rotation.time0_ns = time_ns_;
  rotation.time1_ns = time_ns;
  rotation.log_left0_left1 = R_left1_left0.inverse().log();
  rotation.t_left0_left1 = -(R_left1_left0.inverse() * t_left1_left0);
  rotations_.push_back(rotation);
}

}  // namespace imslam::datasets

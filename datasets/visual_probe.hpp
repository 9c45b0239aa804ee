#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "slam/sensors/calibration.hpp"
#include "slam/sensors/stereo.hpp"

namespace imslam::datasets {

/// Corners of the left image and where Lucas-Kanade finds them in the right one, [px].
struct StereoMatches {
  std::vector<Eigen::Vector2d> left;
  std::vector<Eigen::Vector2d> right;
};

/// Searches in all directions, so that exchanged or unrectified images show.
StereoMatches match_stereo(const GrayImage& left, const GrayImage& right, int max_corners = 200);

/// Rotation of the left camera from time0 to time1 as vision sees it.
struct VisualRotation {
  std::int64_t time0_ns = 0;
  std::int64_t time1_ns = 0;
  Eigen::Vector3d log_left0_left1 = Eigen::Vector3d::Zero();  ///< [rad]
  Eigen::Vector3d t_left0_left1 = Eigen::Vector3d::Zero();    ///< [m], coarse
};

struct ProbePyramid;

/// A coarse stereo odometry for checks only: corners, Lucas-Kanade, PnP with RANSAC. Independent of
/// the front end, so that it can disagree with it.
class VisualProbe {
 public:
  explicit VisualProbe(const StereoCamera& camera);
  ~VisualProbe();
  VisualProbe(const VisualProbe&) = delete;
  VisualProbe& operator=(const VisualProbe&) = delete;

  /// Frames in order; incomplete ones interrupt the chain.
  void add(const StereoFrame& frame);

  const std::vector<VisualRotation>& rotations() const { return rotations_; }
  const std::vector<double>& disparities() const { return disparities_; }          ///< [px]
  const std::vector<double>& row_differences() const { return row_differences_; }  ///< [px]

 private:
  void track(const ProbePyramid& next, std::int64_t time_ns);

  StereoCamera camera_;
  std::unique_ptr<ProbePyramid> pyramid_;  ///< of the previous left image
  std::int64_t time_ns_ = 0;               ///< of the previous frame
  StereoMatches matches_;                  ///< of the previous frame
  std::vector<VisualRotation> rotations_;
  std::vector<double> disparities_;
  std::vector<double> row_differences_;
};

}  // namespace imslam::datasets

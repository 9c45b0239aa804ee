#pragma once

#include <memory>

#include "datasets/camera_model.hpp"
#include "slam/sensors/calibration.hpp"
#include "slam/sensors/stereo.hpp"

namespace imslam::datasets {

/// Turns raw pairs into rectified, undistorted ones.
///
///   p_rectified = R1 p_left,   so   T_body_rectified = T_body_left * [R1^T | 0]
///
/// Both images get the same pinhole (equal fx = fy, cx, cy). With radial-tangential lenses every
/// rectified pixel has an original (alpha = 0); fisheye views are cut to kMaxHalfView to each side,
/// because a pinhole image stretches without bound towards 90 degrees.
/// Method: Bouguet, as in OpenCV's stereoRectify and fisheye::stereoRectify.
class StereoRectifier {
 public:
  static constexpr double kMaxHalfView = 0.96;  ///< [rad], 55 degrees

  /// InputError(kCalibration) if sizes differ, the baseline is not between 1 mm and 10 m, the right
  /// camera is not to the right of the left one, or too little of the views overlaps.
  StereoRectifier(const RawCamera& left, const RawCamera& right);

  /// For images that are rectified on disk.
  explicit StereoRectifier(const StereoCamera& camera);

  ~StereoRectifier();
  StereoRectifier(StereoRectifier&&) noexcept;
  StereoRectifier& operator=(StereoRectifier&&) noexcept;

  const StereoCamera& camera() const { return camera_; }

  /// Images must have the calibrated size; empty ones stay empty.
  GrayImage left(GrayImage raw) const;
  GrayImage right(GrayImage raw) const;

 private:
  struct Map;
  GrayImage apply(const Map& map, GrayImage raw) const;

  StereoCamera camera_;
  std::unique_ptr<Map> left_map_;  ///< null: nothing to do
  std::unique_ptr<Map> right_map_;
};

/// True if camera `b` stands to the left of camera `a`: the two have to change roles.
/// InputError(kCalibration) if they stand above each other or one in front of the other.
bool stands_left_of(const RawCamera& b, const RawCamera& a);

}  // namespace imslam::datasets

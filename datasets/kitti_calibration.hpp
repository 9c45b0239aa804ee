#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "slam/sensors/calibration.hpp"

namespace imslam::datasets {

/// Lines "name: numbers" of KITTI's calibration files; entries that are no numbers are skipped.
class KittiCalibration {
 public:
  /// InputError(kCalibration) if the file cannot be read.
  explicit KittiCalibration(const std::filesystem::path& file);

  bool has(const std::string& name) const { return entries_.count(name) > 0; }

  /// InputError(kCalibration) "file: expected NAME with N numbers" if missing or of other length.
  Eigen::Matrix<double, 3, 4> matrix34(const std::string& name) const;
  Eigen::Matrix3d matrix33(const std::string& name) const;
  Eigen::Vector2d vector2(const std::string& name) const;

  /// R and T (as in calib_imu_to_velo.txt) or Tr (odometry) as a rigid motion.
  lie::SE3d rigid(const std::string& rotation, const std::string& translation) const;
  lie::SE3d rigid34(const std::string& name) const;
  lie::SE3d rotation(const std::string& name) const;  ///< 3x3 alone, no translation

  std::string where(const std::string& name) const;

 private:
  struct Entry {
    std::size_t line = 0;
    std::vector<double> numbers;
  };
  const std::vector<double>& numbers(const std::string& name, std::size_t count) const;

  std::string file_;
  std::map<std::string, Entry> entries_;
};

/// A rectified pair from its 3x4 projections P = K [I | t].
struct KittiPair {
  StereoCamera camera;  ///< T_body_left: body = camera 0
  lie::SE3d T_cam0_left;
};

/// InputError(kCalibration) if the two projections are no rectified pair or the second camera is
/// not to the right of the first.
KittiPair kitti_pair(const KittiCalibration& calibration,
                     const std::string& left,
                     const std::string& right);

/// 3x4 or 4x4 numbers, row major, as in T_cam0_imu.txt (# comments allowed).
lie::SE3d read_rigid_motion_file(const std::filesystem::path& file);

}  // namespace imslam::datasets

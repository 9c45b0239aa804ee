#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

#include "slam/evaluation/rigid_matrix.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::testing {

/// A winding climb with changing orientation: every degree of freedom moves, z stays up.
inline PosePath winding_path(std::size_t poses, double interval_s = 0.05, double start_s = 1000.0) {
  PosePath path;
  path.source = "winding";
  for (std::size_t i = 0; i < poses; ++i) {
    const double s = interval_s * static_cast<double>(i);
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(0.7 * s, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(0.2 * std::sin(s), Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
    path.stamps_s.push_back(start_s + s);
    path.poses.push_back(evaluation::rigid(
        R, {3.0 * std::sin(0.7 * s), 2.0 * std::cos(0.5 * s), 0.3 * s + std::sin(2.0 * s)}));
  }
  return path;
}

/// The same path with small, reproducible errors in position and orientation.
inline PosePath disturbed(PosePath path, double size = 0.02) {
  path.source = "disturbed";
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto k = static_cast<double>(i);
    const Eigen::Vector3d axis =
        Eigen::Vector3d(std::sin(k), std::cos(1.7 * k), std::sin(0.3 * k + 1.0)).normalized();
    path.poses[i] = path.poses[i] *
                    evaluation::rigid(
                        Eigen::AngleAxisd(size * std::sin(3.1 * k), axis).toRotationMatrix(),
                        size * Eigen::Vector3d(std::cos(k), std::sin(2.3 * k), std::cos(5.0 * k)));
  }
  return path;
}

inline PosePath moved(PosePath path, const Eigen::Matrix4d& T) {
  for (Eigen::Matrix4d& pose : path.poses) pose = T * pose;
  return path;
}

inline Eigen::Matrix4d some_motion() {
  return evaluation::rigid(
      Eigen::AngleAxisd(2.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix(),
      {5.0, -7.0, 2.0});
}

}  // namespace imslam::testing

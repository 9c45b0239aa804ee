#pragma once

#include <filesystem>
#include <vector>

#include "datasets/imu_csv.hpp"
#include "datasets/trajectory_file.hpp"
#include "slam/base/time.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::imu::testing {

/// A log of readings in EuRoC's columns.
inline std::vector<ImuSample> read_imu(const std::filesystem::path& file) {
  return datasets::read_imu_csv(file).samples;
}

/// T_world_body of a file with stamps.
inline Trajectory read_truth(const std::filesystem::path& file) {
  const PosePath path = datasets::read_trajectory(file);
  Trajectory trajectory;
  for (std::size_t k = 0; k < path.size(); ++k) {
    trajectory.add(to_nanoseconds(path.stamps_s[k]), lie::SE3d::from_matrix(path.poses[k]));
  }
  return trajectory;
}

/// KITTI poses of camera 0, carried to the IMU; pose k is at `period_ns` k.
inline Trajectory read_kitti_truth(const std::filesystem::path& file,
                                   const lie::SE3d& T_left_body,
                                   std::int64_t period_ns) {
  const PosePath path = datasets::read_trajectory(file);
  Trajectory trajectory;
  for (std::size_t k = 0; k < path.size(); ++k) {
    trajectory.add(period_ns * static_cast<std::int64_t>(k),
                   lie::SE3d::from_matrix(path.poses[k]) * T_left_body);
  }
  return trajectory;
}

/// The part of a trajectory between two poses, as if vision had measured it at shifted stamps.
inline std::vector<RelativeMotion> as_vision(const Trajectory& truth,
                                             std::size_t first,
                                             std::size_t last,
                                             std::size_t stride,
                                             std::int64_t shift_ns,
                                             double rotation_std) {
  std::vector<RelativeMotion> motions;
  for (std::size_t i = first; i + stride < last; i += stride) {
    RelativeMotion motion;
    motion.time0_ns = truth.times_ns[i] + shift_ns;
    motion.time1_ns = truth.times_ns[i + stride] + shift_ns;
    motion.T_body0_body1 = truth.poses[i].inverse() * truth.poses[i + stride];
    motion.covariance *= rotation_std * rotation_std;
    motion.valid = true;
    motions.push_back(motion);
  }
  return motions;
}

}  // namespace imslam::imu::testing

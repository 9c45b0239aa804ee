#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "slam/lie/se3.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::training {

/// True poses of the IMU, T_world_body, and velocities where the file states them.
struct TruthPath {
  Trajectory path;
  std::vector<Eigen::Vector3d> velocities;  ///< v_world [m/s], one per pose; or empty
};

// All throw InputError "file:line: ...", also for stamps that do not increase. Stamps of TUM files
// are read as doubles: to 240 ns, if they count from 1970.

/// T_world_body on the clock of the samples.
TruthPath read_tum_truth(const std::filesystem::path& file);

/// state_groundtruth_estimate0, mocap0 or vicon0 of a EuRoC folder; `T_body_imu`: T_BS of imu0.
/// Columns 9 to 11 are velocities in world, as far as the truth's sensor is the IMU.
TruthPath read_euroc_truth(const std::filesystem::path& mav0, const lie::SE3d& T_body_imu);

/// Poses of KITTI's camera 0, carried to the IMU, in a world with z up: x is where the first camera
/// looks. Stamps: `times_file` if it exists, else multiples of the interval in the comment
/// "nominal interval X s" of `imu_csv`.
TruthPath read_kitti_truth(const std::filesystem::path& poses_file,
                           const std::filesystem::path& imu_csv,
                           const std::filesystem::path& times_file,
                           const lie::SE3d& T_cam0_imu);

}  // namespace imslam::training

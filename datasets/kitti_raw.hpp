#pragma once

#include <filesystem>

#include "datasets/kitti_map.hpp"
#include "datasets/recording.hpp"

namespace imslam::datasets {

/// KITTI raw; `folder` is a drive, `DATE/DATE_drive_NUMBER_sync` (or the name without suffix).
///
///   DATE_drive_NUMBER_sync/image_00, image_01   rectified grey pair; else colour image_02,
///   image_03
///       .../timestamps.txt, data/0000000000.png
///   DATE_drive_NUMBER_extract/oxts              IMU at 100 Hz; without it there is no IMU: the
///                                               10 Hz of _sync are too few to integrate
///   DATE/calib_cam_to_cam.txt, calib_velo_to_cam.txt, calib_imu_to_velo.txt
///   truth: the OXTS solution (of the body), interpolated at the images' stamps
///
/// `RAW/NN`, where RAW holds the date folders and NN is an odometry sequence (00-10), stands for
/// the frames of its drive that make up the sequence: see kitti_drives().
Recording read_kitti_raw(const std::filesystem::path& folder);

bool looks_like_kitti_raw(const std::filesystem::path& folder);

/// IMU for an odometry sequence from the raw drive that it was cut from.
struct RawImu {
  ImuData imu;  ///< on the clock of the sequence's times.txt
  lie::SE3d T_velo_imu;
  std::vector<std::filesystem::path> files;
};

/// Looks for the raw drive near the odometry root (see find_drive()); empty, with a hint in the
/// log, if it is not there. `first_time_ns` is the stamp of the sequence's first frame.
std::optional<RawImu> find_raw_imu(const std::filesystem::path& odometry_root,
                                   const std::string& sequence,
                                   std::int64_t first_time_ns,
                                   std::int64_t last_time_ns);

}  // namespace imslam::datasets

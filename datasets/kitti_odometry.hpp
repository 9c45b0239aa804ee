#pragma once

#include <filesystem>

#include "datasets/recording.hpp"

namespace imslam::datasets {

/// KITTI odometry; `folder` is `.../sequences/NN`, or the root if it holds a single sequence.
///
///   sequences/NN/image_0, image_1     rectified grey pair; else colour image_2, image_3
///   sequences/NN/calib.txt            P0 P1 (P2 P3): 3x4 projections; Tr: velodyne to camera 0
///   sequences/NN/times.txt            [s], line i belongs to image i
///   sequences/NN/imu.csv              optional: EuRoC columns, on the clock of times.txt
///   sequences/NN/T_cam0_imu.txt       with imu.csv: p_cam0 = T p_imu
///   poses/NN.txt                      optional truth of camera 0, one 3x4 matrix per image
///
/// Without imu.csv, a KITTI raw folder near the root supplies the IMU, see find_raw_imu().
/// Truth gets the stamps of the images; it is left out, with a warning, if the counts differ.
Recording read_kitti_odometry(const std::filesystem::path& folder);

bool looks_like_kitti_odometry(const std::filesystem::path& folder);

/// Continuous-time noise of KITTI's OXTS RT3003. Its datasheet states 0.2 deg/sqrt(h) (5.8e-5
/// rad/s/sqrt(Hz)) and 0.005 m/s/sqrt(h) (8e-5 m/s^2/sqrt(Hz)) for the sensor alone; in the car the
/// output is filtered, resampled to 100 Hz and shaken, so both are set as measured on the road.
ImuNoise kitti_imu_noise();

}  // namespace imslam::datasets

#pragma once

#include <filesystem>

#include "datasets/recording.hpp"

namespace imslam::datasets {

/// EuRoC (ASL) layout; `folder` is the one that holds mav0, or mav0 itself.
///
///   mav0/cam{0,1}/data.csv      time_ns, file name; without it, images named by their stamp
///   mav0/cam{0,1}/data/         PNG or JPEG, grey or colour, 8 or 16 bit
///   mav0/cam{0,1}/sensor.yaml   T_BS, resolution, intrinsics, distortion
///   mav0/imu0/                  data.csv, sensor.yaml (optional folder)
///   truth                       state_groundtruth_estimate0, vicon0 or mocap0: data.csv with or
///                               without velocity and bias columns, optional sensor.yaml
///
/// TUM-VI's variant: equidistant cameras, or dso/camchain.yaml (+ dso/imu_config.yaml) beside mav0
/// instead of the cameras' sensor.yaml. The format is then called "tumvi".
///
/// Body is imu0: where its T_BS is not the identity, cameras and truth are moved to it. If cam1
/// stands to the left of cam0, the two change roles, with a message.
/// InputError: kData for index and csv files, kCalibration for sensor.yaml.
Recording read_euroc(const std::filesystem::path& folder);

bool looks_like_euroc(const std::filesystem::path& folder);

}  // namespace imslam::datasets

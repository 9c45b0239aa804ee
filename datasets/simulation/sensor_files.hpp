#pragma once

#include <string>

#include "datasets/simulation/lens.hpp"
#include "slam/lie/se3.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::simulation {

/// Contents of the ASL sensor.yaml files, as in the EuRoC data set.
std::string camera_file(const Lens& lens,
                        const lie::SE3d& T_body_camera,
                        double rate_hz,
                        const std::string& comment);
std::string imu_file(const ImuNoise& noise);
std::string truth_file();

}  // namespace imslam::simulation

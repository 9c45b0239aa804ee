#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "slam/lie/se3.hpp"

namespace imslam::testing {

struct StampedPose {
  double time_s = 0.0;
  lie::SE3d T;
};

/// "seconds tx ty tz qx qy qz qw" per line.
inline std::vector<StampedPose> read_tum(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<StampedPose> poses;
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    double v[8] = {};
    for (double& value : v) cells >> value;
    const Eigen::Quaterniond rotation(v[7], v[4], v[5], v[6]);
    poses.push_back({v[0], lie::SE3d(lie::SO3d(rotation), Eigen::Vector3d(v[1], v[2], v[3]))});
  }
  return poses;
}

}  // namespace imslam::testing

#include "slam/system/library_versions.hpp"

#include <fmt/format.h>
#include <pcl/pcl_config.h>
#include <spdlog/version.h>
#include <Eigen/Core>

namespace imslam::system {

std::map<std::string, std::string> library_versions() {
  return {{"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"ceres", IMSLAM_CERES_VERSION},
          {"opencv", IMSLAM_OPENCV_VERSION},
          {"pcl", PCL_VERSION_PRETTY},
          {"compiler", __VERSION__}};
}

}  // namespace imslam::system

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/lie/se3.hpp"
#include "slam/sensors/stereo.hpp"
#include "vo_net/matcher.hpp"

namespace imslam::vo {

/// A view that may be seen again.
struct Keyframe {
  std::int64_t time_ns = 0;
  lie::SE3d T_map_left;                     ///< the left camera in the map
  Eigen::Matrix<double, 6, 6> covariance =  ///< of the *body's* pose, right tangent
      Eigen::Matrix<double, 6, 6>::Zero();
  GrayImage left;                   ///< the pyramid is built anew when it is needed
  std::vector<StereoPoint> points;  ///< what was seen, depth included
  double median_disparity = 1.0;    ///< [px]

  std::size_t bytes() const {
    return sizeof(Keyframe) + left.pixels.capacity() + points.capacity() * sizeof(StereoPoint);
  }
};

}  // namespace imslam::vo

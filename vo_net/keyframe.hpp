#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/lie/se3.hpp"
#include "slam/sensors/stereo.hpp"
#include "vo_net/matcher.hpp"

namespace imslam::vo {

/// How uncertain the odometry has become, whatever was recognised on the way.
struct Drift {
  double translation = 0.0;  ///< [m^2] per axis
  double rotation = 0.0;     ///< [rad^2]
};

/// A view that may be seen again.
struct Keyframe {
  std::int64_t time_ns = 0;
  lie::SE3d T_map_left;                     ///< the left camera in the map
  Eigen::Matrix<double, 6, 6> covariance =  ///< of the *body's* motion from then to now
      Eigen::Matrix<double, 6, 6>::Zero();  ///< right tangent
  Drift drift;                              ///< of the odometry up to then
  GrayImage left;                           ///< the pyramid is built anew when it is needed
  std::vector<StereoPoint> points;          ///< what was seen, depth included
  double median_disparity = 1.0;            ///< [px]

  std::size_t bytes() const {
    return sizeof(Keyframe) + left.pixels.capacity() + points.capacity() * sizeof(StereoPoint);
  }
};

}  // namespace imslam::vo

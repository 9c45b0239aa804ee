#pragma once

#include <Eigen/Core>

#include "slam/base/random.hpp"
#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/correspondence.hpp"

namespace imslam::testing {

inline StereoCamera test_camera() {
  StereoCamera camera;
  camera.width = 752;
  camera.height = 480;
  camera.fx = 435.0;
  camera.fy = 437.0;
  camera.cx = 367.0;
  camera.cy = 252.0;
  camera.baseline_m = 0.11;
  camera.T_body_left = lie::SE3d(lie::SO3d::exp(Eigen::Vector3d(0.1, -1.2, 0.8)),
                                 Eigen::Vector3d(0.02, -0.06, 0.01));
  return camera;
}

inline lie::SE3d test_motion() {
  return lie::SE3d::exp((lie::SE3d::Tangent() << 0.08, -0.03, 0.05, 0.02, -0.015, 0.03).finished());
}

struct PointNoise {
  double flow = 0.0;       ///< [px]
  double disparity = 0.0;  ///< [px]
  double offset = 0.0;     ///< [px] on every disparity
};

/// `count` points spread over the image between 1 and 12 m, seen from both ends of T_body0_body1.
/// Informations are those of the noise (those of 0.1 px where there is none).
inline vo::Correspondences synthetic_correspondences(const StereoCamera& camera,
                                                     const lie::SE3d& T_body0_body1,
                                                     int count,
                                                     const PointNoise& noise,
                                                     Random& random) {
  const lie::SE3d T_left1_left0 =
      camera.T_body_left.inverse() * T_body0_body1.inverse() * camera.T_body_left;
  const double sigma_flow = noise.flow > 0.0 ? noise.flow : 0.1;
  const double sigma_disparity = noise.disparity > 0.0 ? noise.disparity : 0.1;
  vo::Correspondences correspondences;
  while (static_cast<int>(correspondences.size()) < count) {
    const Eigen::Vector2d left0{random.uniform(20.0, camera.width - 20.0),
                                random.uniform(20.0, camera.height - 20.0)};
    const double depth = random.uniform(1.0, 12.0);
    const double disparity0 = camera.fx * camera.baseline_m / depth;
    const Eigen::Vector3d uvd =
        camera.project(T_left1_left0 * camera.back_project({left0.x(), left0.y(), disparity0}));
    vo::Correspondence c;
    c.left0 = left0;
    c.left1 = uvd.head<2>() + noise.flow * Eigen::Vector2d{random.normal(), random.normal()};
    c.disparity0 = disparity0 + noise.disparity * random.normal() + noise.offset;
    c.disparity1 = uvd.z() + noise.disparity * random.normal() + noise.offset;
    c.flow_information = Eigen::Matrix2d::Identity() / (sigma_flow * sigma_flow);
    c.disparity0_information = 1.0 / (sigma_disparity * sigma_disparity);
    c.disparity1_information = c.disparity0_information;
    c.track_id = static_cast<std::int64_t>(correspondences.size());
    correspondences.push_back(c);
  }
  return correspondences;
}

}  // namespace imslam::testing

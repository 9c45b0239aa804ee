#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/vo_net/synthetic_images.hpp"
#include "vo_net/matcher.hpp"

namespace imslam::testing {

inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

struct MatchErrors {
  std::vector<double> flow;       ///< [px]
  std::vector<double> disparity;  ///< [px]
};

/// Against what the plane and the poses say.
inline MatchErrors errors_of(const vo::Correspondences& correspondences,
                             const PlaneWorld& world,
                             const StereoCamera& camera,
                             const lie::SE3d& T_world_left0,
                             const lie::SE3d& T_world_left1) {
  MatchErrors errors;
  const lie::SE3d T_left1_left0 = T_world_left1.inverse() * T_world_left0;
  for (const vo::Correspondence& c : correspondences) {
    const double z = world.depth(camera, T_world_left0, c.left0.x(), c.left0.y());
    const double disparity0 = camera.fx * camera.baseline_m / z;
    const Eigen::Vector3d uvd =
        camera.project(T_left1_left0 * camera.back_project({c.left0.x(), c.left0.y(), disparity0}));
    errors.flow.push_back((c.left1 - uvd.head<2>()).norm());
    errors.disparity.push_back(std::abs(c.disparity0 - disparity0));
    errors.disparity.push_back(std::abs(c.disparity1 - uvd.z()));
  }
  return errors;
}

}  // namespace imslam::testing

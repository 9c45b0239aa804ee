#pragma once

#include "datasets/simulation/lens.hpp"
#include "datasets/simulation/options.hpp"
#include "slam/base/random.hpp"
#include "slam/lie/se3.hpp"

namespace imslam::simulation {

/// Two raw cameras on a body. Body: x forward, y left, z up (= IMU); cameras: x right, y down,
/// z forward.
struct StereoRig {
  Lens left;
  Lens right;
  lie::SE3d T_body_left;
  lie::SE3d T_body_right;
};

/// The preset with the options' changes and, by chance, imperfect mounting: intrinsics of left and
/// right differ a little and the optical axes are not quite parallel.
StereoRig make_rig(const CameraOptions& options, Random random);

}  // namespace imslam::simulation

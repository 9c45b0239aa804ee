#pragma once

#include <vector>

#include "datasets/simulation/lens.hpp"
#include "datasets/simulation/view.hpp"

namespace imslam::simulation {

/// Depth along the optical axis [m] of every pixel, 0 for the sky.
std::vector<float> depth_of(const View& view, const RayTable& rays);

struct Flow {
  std::vector<float> displacement;  ///< [px] column and row change, interleaved
  std::vector<std::uint8_t> valid;  ///< 1: lands inside the image
};

/// Where the points seen at t0 are in the same camera's image at t1, minus where they were.
Flow flow_of(const View& view,
             const World& world,
             const RayTable& rays,
             const Lens& lens,
             const lie::SE3d& T_world_camera0,
             const lie::SE3d& T_world_camera1,
             double t0,
             double t1);

}  // namespace imslam::simulation

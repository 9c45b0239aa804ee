#pragma once

#include <functional>

#include "datasets/simulation/motion_spline.hpp"
#include "datasets/simulation/options.hpp"

namespace imslam::simulation {

/// Travelling time along the scene's path at clock time t [s]: zero during the rest, then a smooth
/// start up to options.speed.
double travel_time(const SimulationOptions& options, double t);

/// The motion that the options ask for along a scene's path: rest, gentle start, travel; or one of
/// the special motions (static, pure_rotation, free_fall) at the beginning of the path.
/// Covers [0, duration_s + one frame], so that flow to the next frame always exists.
MotionSpline make_motion(const SimulationOptions& options,
                         const std::function<lie::SE3d(double)>& path);

}  // namespace imslam::simulation

#pragma once

#include <vector>

#include "datasets/simulation/vibration.hpp"
#include "slam/base/random.hpp"
#include "slam/lie/se3.hpp"

namespace imslam::training {

/// How something that carries an inertial sensor moved: control poses of a MotionSpline of
/// kKnot_s, z of the world up, the vehicle's x forward and z up, and when it vibrated.
struct InertialMotion {
  std::vector<lie::SE3d> T_world_vehicle;
  std::vector<simulation::VibrationLevel> vibration;  ///< empty: nothing runs
};

/// A multirotor: rests, starts its rotors, climbs, flies by velocity commands, hovers, lands.
///
/// Only thrust (along z of the vehicle) and drag act on it in the air,
///   f = thrust e_z - drag (v - wind),
/// so its attitude follows from its acceleration and its accelerometer does not see the tilt.
InertialMotion drone_motion(double duration_s, Random random);

/// In a hand: rests on a table, is picked up, swayed, shaken (rates up to 3 to 5 rad/s), carried
/// at a walk of 1.5 to 2.2 steps per second.
InertialMotion hand_motion(double duration_s, Random random);

/// A car in a town or on a highway, up to 25 m/s: lights, turns, bends, hills; body roll and pitch
/// on the suspension.
InertialMotion car_motion(double duration_s, Random random);

/// A slow robot on wheels that turns on the spot, on floors or rough ground.
InertialMotion rover_motion(double duration_s, Random random);

}  // namespace imslam::training

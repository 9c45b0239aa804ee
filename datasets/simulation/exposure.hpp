#pragma once

#include <vector>

#include "datasets/simulation/motion_spline.hpp"
#include "datasets/simulation/options.hpp"
#include "datasets/simulation/view.hpp"
#include "datasets/simulation/world.hpp"
#include "slam/base/random.hpp"

namespace imslam::simulation {

/// How the camera's gain changes over a sequence: it follows the brightness of what is in view
/// with a lag, as automatic exposure does, and jumps now and then if asked to.
class Exposure {
 public:
  /// Looks along the motion with a coarse grid of rays, twice per second.
  Exposure(const SimulationOptions& options,
           World& world,
           const RayTable& rays,
           const MotionSpline& motion,
           const lie::SE3d& T_body_left,
           Random random);

  /// Grey value of full scale per radiance.
  double gain(double time_s) const;
  double right_factor() const { return right_factor_; }

 private:
  std::vector<double> log_gains_;  ///< every kProbe_s
  double right_factor_ = 1.0;
};

}  // namespace imslam::simulation

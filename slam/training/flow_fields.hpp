#pragma once

#include <cstdint>

#include "slam/base/config.hpp"
#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/correspondence.hpp"

namespace imslam::training {

struct FlowFieldOptions {
  int seed = 1;
  int least_points = 120;
  int most_points = 1000;
  double least_noise = 0.03;     ///< [px] of the flow, standard deviation
  double most_noise = 0.5;       ///< [px]
  double most_outliers = 0.3;    ///< [1] share, in the fields that have any
  double with_outliers = 0.6;    ///< [1] share of the fields
  double with_movers = 0.25;     ///< [1] share of the fields in which things move by themselves
  double standing_still = 0.05;  ///< [1] share of the fields without translation

  void describe(Config& config);
  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
};

/// What a matcher would have found, and the truth.
struct FlowField {
  StereoCamera camera;
  lie::SE3d T_left0_left1;
  vo::Correspondences correspondences;
};

/// Flow of made-up cameras that move through made-up scenes; no images.
///
///   camera    50 to 105 degrees wide, of the shapes of EuRoC, KITTI and in between
///   scene     rooms, streets, ground from above, clutter, smooth relief, see FlowScene
///   motion    hand and drone: any direction, turns about any axis; vehicle: nearly forward, yaw;
///             lengths in units of the median depth
///   matches   on a jittered grid or anywhere, thinned in patches, with noise, outliers, holes and
///             things that move by themselves
///
/// Field i depends on the seed and i alone.
class FlowFieldGenerator {
 public:
  explicit FlowFieldGenerator(const FlowFieldOptions& options);

  FlowField make(std::uint64_t index) const;

 private:
  FlowFieldOptions options_;
};

}  // namespace imslam::training

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "datasets/simulation/motion_spline.hpp"
#include "datasets/simulation/ray_table.hpp"
#include "datasets/simulation/world.hpp"
#include "slam/lie/se3.hpp"

namespace imslam::simulation {

/// Where a camera is and how it moves; velocities in the camera frame.
struct CameraMotion {
  lie::SE3d T_world_camera;
  Eigen::Vector3d v_camera = Eigen::Vector3d::Zero();      ///< [m/s]
  Eigen::Vector3d omega_camera = Eigen::Vector3d::Zero();  ///< [rad/s]
};

CameraMotion camera_motion(const MotionState& body, const lie::SE3d& T_body_camera);

/// What a perfect camera sees at one instant; row major, width * height.
struct View {
  int width = 0;
  int height = 0;
  std::vector<float> radiance;          ///< light, 1 = white under full light
  std::vector<float> distance;          ///< [m] along the unit ray of the pixel's centre; sky: inf
  std::vector<std::uint32_t> surface;   ///< changes at edges
  std::vector<std::uint32_t> instance;  ///< as in Hit

  std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  }
};

/// Traces one ray per pixel and, with `antialias`, four more where surfaces meet, or one more per
/// pixel where nearly all pixels are edges. Parallel over rows. `view` is reused.
void render_view(const World& world,
                 const RayTable& rays,
                 const lie::SE3d& T_world_camera,
                 bool antialias,
                 View& view);

/// Smears the radiance along the true image motion of `exposure_s`; the instant of the view is the
/// middle of the exposure. `time_s` is that instant, for things that move by themselves.
std::vector<float> blur_motion(const View& view,
                               const World& world,
                               const RayTable& rays,
                               const CameraMotion& motion,
                               double time_s,
                               double exposure_s);

}  // namespace imslam::simulation

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "datasets/simulation/lens.hpp"
#include "datasets/simulation/motion_spline.hpp"
#include "datasets/simulation/world.hpp"
#include "slam/lie/se3.hpp"

namespace imslam::simulation {

/// The rays of all pixels of a lens, computed once.
class RayTable {
 public:
  explicit RayTable(const Lens& lens);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Unit direction in the camera frame; row in [-1, height], column in [-1, width].
  const Eigen::Vector3f& direction(int row, int column) const {
    return directions_[static_cast<std::size_t>((row + 1) * (width_ + 2) + column + 1)];
  }
  /// The same in double precision, within the image only.
  const Eigen::Vector3d& exact_direction(int row, int column) const {
    return exact_[static_cast<std::size_t>(row * width_ + column)];
  }
  /// Change of the pixel [px] per change of the (not necessarily unit) direction; blind to changes
  /// along the ray.
  const Eigen::Matrix<float, 2, 3>& J_pixel_direction(int row, int column) const {
    return pixel_changes_[static_cast<std::size_t>(row * width_ + column)];
  }
  Eigen::Vector3f d_column(int row, int column) const {
    return 0.5F * (direction(row, column + 1) - direction(row, column - 1));
  }
  Eigen::Vector3f d_row(int row, int column) const {
    return 0.5F * (direction(row + 1, column) - direction(row - 1, column));
  }

 private:
  int width_;
  int height_;
  std::vector<Eigen::Vector3f> directions_;
  std::vector<Eigen::Vector3d> exact_;
  std::vector<Eigen::Matrix<float, 2, 3>> pixel_changes_;
};

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

/// Traces one ray per pixel and, with `antialias`, four more where surfaces meet. Parallel over
/// rows. `view` is reused.
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

#pragma once

#include <vector>

#include "datasets/visual_probe.hpp"
#include "slam/lie/se3.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::datasets {

/// How the lengths that vision measures fit the accelerometer.
///
/// D is the difference of the mean velocities before and after a moment, per second. Of the body's
/// true path p, with the specific force f, the orientation R that vision saw, and gravity g:
///
///   D(p) = g + D( integral integral R f ) - R b,   and p = u / scale + l
///
/// where u is the path of the camera as vision saw it and l the known path of the lever arm. Least
/// squares over all moments for scale, bias b and, per unbroken stretch, gravity g.
struct ScaleComparison {
  int moments = 0;          ///< used, after outliers were left out
  double scale = 1.0;       ///< vision moves by this factor farther than the accelerometer says
  double sigma = 0.0;       ///< of scale
  double gravity = 0.0;     ///< [m/s^2] mean magnitude of g
  double excitation = 0.0;  ///< [m/s^2] how much the acceleration varies, rms
  bool valid = false;       ///< enough moments, and scale known to a tenth
};

/// `vision`: motions in order of time; what is not contiguous starts a new stretch, and so does a
/// gap in the IMU. `time_offset_s`: t_imu = t_camera + offset.
ScaleComparison compare_scale(const std::vector<VisualRotation>& vision,
                              const std::vector<ImuSample>& imu,
                              const lie::SE3d& T_body_left,
                              double time_offset_s);

}  // namespace imslam::datasets

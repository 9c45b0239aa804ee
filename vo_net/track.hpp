#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "slam/base/parallel.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/matcher.hpp"

namespace imslam::vo {

struct Disparity {
  double value = 0.0;      ///< [px]
  double variance = 1.0;   ///< [px^2]
  double row_error = 0.0;  ///< [px] v_right - v_left, 0 for perfect rectification
  bool learned = false;    ///< the answer of a network, not a fit to pixels
};

/// A point that lives in the newest frame.
struct Track {
  std::int64_t id = 0;
  Eigen::Vector2d left = Eigen::Vector2d::Zero();
  Disparity disparity;
  double confidence = 1.0;  ///< [1] that the disparity is right
};

/// Where a point of the left image was found in the next one.
struct Arrival {
  Eigen::Vector2d left = Eigen::Vector2d::Zero();            ///< [px]
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< [px^2]
  double confidence = 1.0;                                   ///< [1] that it is the same point
  bool learned = false;                                      ///< the answer of a network
  bool coarse = false;                                       ///< found in shrunken images
};

/// [u v disparity] after the motion; the point itself where it would be behind the camera.
Eigen::Vector3d predict(const StereoCamera& camera,
                        const Track& track,
                        const lie::SE3d& T_left1_left0);

/// One point seen by both pairs. `sigma_floor` [px]: error that no covariance explains. The weight
/// is the confidence of the weakest of the three measurements.
Correspondence make_correspondence(const Track& before,
                                   const Arrival& left1,
                                   const Track& now,
                                   double sigma_floor);

StereoPoint make_stereo_point(const Track& track, double sigma_floor);

void erase_tracks(std::vector<Track>& tracks, const std::vector<std::int64_t>& ids);

/// body(i) for every i < count, in parallel tasks of several points; see parallel_for.
template <typename Body>
void parallel_points(std::size_t count, const Body& body) {
  constexpr std::size_t kChunk = 32;
  parallel_for((count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    const std::size_t end = std::min(count, (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i) body(i);
  });
}

}  // namespace imslam::vo

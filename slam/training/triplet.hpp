#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"

namespace imslam::training {

/// What is known about the match of a pixel of left0 in another view.
enum class MatchState : std::uint8_t {
  kVisible,  ///< seen in the other view too
  kHidden,   ///< something stands in front of it there
  kOutside,  ///< beyond the centres of the other view's border pixels
  kNone,     ///< behind the other camera: displacement and match mean nothing
};

/// One training sample: the left and right view at t-1 (left0, right0) and the left view at t
/// (left1), with the exact displacements of the pixels of left0. All arrays are row major,
/// width * height; integer coordinates are pixel centres.
///
///   right0(u - disparity, v) shows what left0(u, v) shows
///   left1(u + flow_u, v + flow_v) shows what left0(u, v) shows
struct Triplet {
  StereoCamera camera;
  lie::SE3d T_left1_left0;  ///< of the camera against everything that does not move by itself

  std::vector<float> left0, right0, left1;  ///< grey [0, 255]

  std::vector<float> disparity;       ///< [px], positive
  std::vector<float> flow_u, flow_v;  ///< [px]
  std::vector<MatchState> disparity_state;
  std::vector<MatchState> flow_state;

  std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(camera.width) +
           static_cast<std::size_t>(column);
  }
};

}  // namespace imslam::training

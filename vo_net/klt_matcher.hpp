#pragma once

#include <memory>
#include <vector>

#include "slam/base/config.hpp"
#include "slam/sensors/calibration.hpp"
#include "vo_net/matcher.hpp"

namespace imslam::vo {

struct KltOptions {
  int max_points = 600;           ///< about; at most one point per cell of a grid
  int levels = 4;                 ///< of the image pyramid
  int window = 0;                 ///< [px] odd, <= 23: side of the patches followed over time
  int stereo_window = 0;          ///< [px] likewise left to right; 0, both: by the image's width
  double smoothing = 0.8;         ///< [px] sigma of the Gaussian on the images, 0: none
  double min_correlation = 0.7;   ///< [1] of a patch with its match
  double max_round_trip = 0.5;    ///< [px] forward and backward must meet
  double max_row_error = 2.0;     ///< [px] between left and right
  bool stereo_along_row = false;  ///< search the right image on the same row only
  double max_disparity = 0.25;    ///< [image widths]
  double min_quality = 2.0;       ///< [grey^2/px^2] smaller eigenvalue of the structure tensor
  double sigma_floor = 0.05;      ///< [px] error of a match that texture does not explain
  int keyframe_age = 0;           ///< [frames] skip edges reach back so far; 0: none
  double keyframe_overlap = 0.5;  ///< [1] share of points below which a keyframe is replaced

  void describe(Config& config);
  void validate() const;

  /// With the windows that suit an image [px]: a patch that covers more of the scene mixes depths,
  /// and its disparity leans towards the background. 15 px from 752 px of width on, 9 at least.
  KltOptions for_width(int width) const;
};

/// Corners followed by Lucas-Kanade from frame to frame and from left to right.
///
/// Patches are compared up to gain and offset, so exposure may change freely. The accepted matches
/// carry the information of their texture and residual. Points that are lost are replaced by new
/// corners in the cells that became empty.
class KltMatcher final : public Matcher {
 public:
  KltMatcher(const KltOptions& options, const StereoCamera& camera);
  ~KltMatcher() override;

  MatchResult match(const StereoFrame& frame, const lie::SE3d& T_body0_body1_predicted) override;
  void drop(const std::vector<std::int64_t>& track_ids) override;
  void forget_newest() override;
  void reset() override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace imslam::vo

#pragma once

#include <Eigen/Core>
#include <optional>

#include "vo_net/klt_matcher.hpp"
#include "vo_net/patch_aligner.hpp"

namespace imslam::vo {

struct Disparity {
  double value = 0.0;      ///< [px]
  double variance = 1.0;   ///< [px^2]
  double row_error = 0.0;  ///< [px] v_right - v_left, 0 for perfect rectification
};

/// Finds points of the left image in the right one of a rectified pair.
class StereoMatcher {
 public:
  StereoMatcher(const KltOptions& options, const ImagePyramid& left, const ImagePyramid& right);

  /// Starts at an expected disparity [px]; empty if the patch is not there.
  std::optional<Disparity> refine(const Eigen::Vector2d& left, double expected) const;

  /// Searches the whole row.
  std::optional<Disparity> search(const Eigen::Vector2d& left) const;

 private:
  std::optional<Disparity> accept(const Eigen::Vector2d& left, double start, int level) const;

  const KltOptions& options_;
  const ImagePyramid& left_;
  const ImagePyramid& right_;
  AlignOptions align_;
};

}  // namespace imslam::vo

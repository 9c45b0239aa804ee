#pragma once

#include <Eigen/Core>
#include <optional>

#include "vo_net/klt_matcher.hpp"
#include "vo_net/patch_aligner.hpp"
#include "vo_net/track.hpp"

namespace imslam::vo {

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

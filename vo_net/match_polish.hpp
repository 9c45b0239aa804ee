#pragma once

#include <optional>

#include "vo_net/learned_options.hpp"
#include "vo_net/match_inference.hpp"
#include "vo_net/patch_aligner.hpp"

namespace imslam::vo {

/// Improves answers of the network where the images allow it.
class MatchPolish {
 public:
  /// options.for_width() must have been called.
  explicit MatchPolish(const LearnedMatcherOptions& options);

  /// Lucas-Kanade at full size from the answer about `center` on. Empty where the answer is better
  /// left alone: it is too uncertain, or nothing similar enough lies close enough.
  std::optional<Alignment> polish(const ImagePyramid& from,
                                  const Eigen::Vector2d& center,
                                  const ImagePyramid& to,
                                  const NetworkAnswer& answer) const;

  /// Whether there is anything to see around p: black, white and blank walls match anything.
  bool shows_something(const ImagePyramid& image, const Eigen::Vector2d& p) const;

 private:
  LearnedMatcherOptions options_;
  AlignOptions align_;
};

}  // namespace imslam::vo

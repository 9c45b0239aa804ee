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

  /// The same on images of half and quarter size, whose blur and noise are that much less; limits
  /// and covariance grow along. For answers that polish() leaves alone.
  std::optional<Alignment> polish_coarse(const ImagePyramid& from,
                                         const Eigen::Vector2d& center,
                                         const ImagePyramid& to,
                                         const NetworkAnswer& answer) const;

  /// Whether there is anything to see around p: black, white and blank walls match anything.
  bool shows_something(const ImagePyramid& image, const Eigen::Vector2d& p) const;

 private:
  bool accepts(const Alignment& found, const Eigen::Vector2d& start, double scale) const;

  LearnedMatcherOptions options_;
  AlignOptions align_;
};

}  // namespace imslam::vo

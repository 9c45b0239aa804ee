#include "vo_net/stereo_matcher.hpp"

#include <algorithm>
#include <cmath>

namespace imslam::vo {
namespace {

constexpr int kSearchLevel = 2;  // quarter size: a step of one pixel stays within reach of the fit
constexpr int kSearchWindow = 11;      // [px] at that size
constexpr int kRefineLevel = 1;        // a predicted disparity is a few pixels off at most
constexpr double kMinDisparity = 0.0;  // [px] less is behind infinity, but for noise
constexpr double kNoise = 1.0;         // [px] that noise may carry a far point beyond infinity

}  // namespace

StereoMatcher::StereoMatcher(const KltOptions& options,
                             const ImagePyramid& left,
                             const ImagePyramid& right)
    : options_(options), left_(left), right_(right) {
  align_.window = options.stereo_window;
  align_.smoothing = options.smoothing;
}

std::optional<Disparity> StereoMatcher::accept(const Eigen::Vector2d& left,
                                               double start,
                                               int level) const {
  const Eigen::Vector2d guess(left.x() - start, left.y());
  const Alignment forth =
      align_patch(left_, left, right_, guess, level, align_, options_.stereo_along_row);
  if (!forth.found || forth.correlation < options_.min_correlation) return std::nullopt;
  const double disparity = left.x() - forth.position.x();
  if (std::abs(forth.position.y() - left.y()) > options_.max_row_error ||
      disparity < kMinDisparity - kNoise || disparity > options_.max_disparity * left_[0].width) {
    return std::nullopt;
  }
  const Alignment back =
      align_patch(right_, forth.position, left_, left, 0, align_, options_.stereo_along_row);
  if (!back.found || (back.position - left).norm() > options_.max_round_trip) return std::nullopt;
  return Disparity{disparity, forth.covariance(0, 0), forth.position.y() - left.y()};
}

std::optional<Disparity> StereoMatcher::refine(const Eigen::Vector2d& left, double expected) const {
  return accept(left, expected, kRefineLevel);
}

std::optional<Disparity> StereoMatcher::search(const Eigen::Vector2d& left) const {
  const int level = std::min(kSearchLevel, static_cast<int>(left_.levels().size()) - 1);
  const double scale = 1.0 / static_cast<double>(1 << level);
  PatchTemplate patch;
  if (!patch.take(left_[level], left * scale, kSearchWindow)) return std::nullopt;

  const int last = static_cast<int>(options_.max_disparity * left_[level].width);
  double best = -1.0;
  int best_disparity = 0;
  for (int d = 0; d <= last && left.x() * scale - d >= 0.0; ++d) {
    const double correlation =
        patch.correlation_at(right_[level], left * scale - Eigen::Vector2d(d, 0.0));
    if (correlation <= best) continue;
    best = correlation;
    best_disparity = d;
  }
  return accept(left, best_disparity / scale, level);
}

}  // namespace imslam::vo

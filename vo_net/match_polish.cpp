#include "vo_net/match_polish.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "vo_net/warped_patch.hpp"

namespace imslam::vo {
namespace {

constexpr int kContrastRadius = 15;  // [px], about what a cell at 1/16 sees at least
constexpr int kContrastStep = 2;     // [px]
constexpr int kContrastLanes = kContrastRadius + 1;
static_assert(2 * kContrastRadius == (kContrastLanes - 1) * kContrastStep);
static_assert(kContrastRadius < ImagePyramid::kBorder);

double larger_variance(const Eigen::Matrix2d& covariance) {
  const double half_trace = 0.5 * covariance.trace();
  const double rest = half_trace * half_trace - covariance.determinant();
  return half_trace + std::sqrt(std::max(0.0, rest));
}

}  // namespace

MatchPolish::MatchPolish(const LearnedMatcherOptions& options) : options_(options) {
  align_.window = options.polish_window;
  align_.smoothing = options.smoothing;
}

std::optional<Alignment> MatchPolish::polish(const ImagePyramid& from,
                                             const Eigen::Vector2d& center,
                                             const ImagePyramid& to,
                                             const NetworkAnswer& answer) const {
  const double largest = options_.max_polish_sigma * options_.max_polish_sigma;
  if (!options_.polish || larger_variance(answer.covariance) > largest) return std::nullopt;
  const Eigen::Vector2d start = center + answer.displacement;
  const Alignment found = align_patch(from, center, to, start, 0, align_, false);
  return accepts(found, start, 1.0) ? std::optional(found) : std::nullopt;
}

std::optional<Alignment> MatchPolish::polish_coarse(const ImagePyramid& from,
                                                    const Eigen::Vector2d& center,
                                                    const ImagePyramid& to,
                                                    const NetworkAnswer& answer) const {
  if (!options_.polish) return std::nullopt;
  const Eigen::Vector2d start = center + answer.displacement;
  for (int level = 1; level <= options_.coarse_polish; ++level) {
    const double scale = std::pow(2.0, level);
    if (larger_variance(answer.covariance) > std::pow(scale * options_.max_polish_sigma, 2)) {
      continue;
    }
    const Alignment found = align_warped(from, {center, start}, to, start, level, level, align_);
    if (accepts(found, start, scale)) return found;
  }
  return std::nullopt;
}

bool MatchPolish::accepts(const Alignment& found,
                          const Eigen::Vector2d& start,
                          double scale) const {
  return found.found && found.correlation >= options_.min_polish_correlation &&
         (found.position - start).norm() <= scale * options_.max_polish_move;
}

bool MatchPolish::shows_something(const ImagePyramid& image, const Eigen::Vector2d& p) const {
  const ImagePyramid::Level& level = image[0];
  const int x = std::clamp(static_cast<int>(std::lround(p.x())), 0, level.width - 1);
  const int y = std::clamp(static_cast<int>(std::lround(p.y())), 0, level.height - 1);
  using Lanes = Eigen::Array<double, kContrastLanes, 1>;
  using Row = Eigen::Map<const Eigen::Array<float, kContrastLanes, 1>, 0,
                         Eigen::InnerStride<kContrastStep>>;
  const auto reference = static_cast<double>(*level.at(x, y));  // sums stay small and exact
  Lanes sums = Lanes::Zero();
  Lanes squares = Lanes::Zero();
  for (int dy = -kContrastRadius; dy <= kContrastRadius; dy += kContrastStep) {
    const Lanes values = Row(level.at(x - kContrastRadius, y + dy)).cast<double>() - reference;
    sums += values;
    squares += values * values;
  }
  constexpr double kCount = double(kContrastLanes) * kContrastLanes;
  const double mean = sums.sum() / kCount;
  const double variance = squares.sum() / kCount - mean * mean;
  return variance > options_.min_contrast * options_.min_contrast;
}

}  // namespace imslam::vo

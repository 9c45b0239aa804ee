#include "vo_net/warped_patch.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace imslam::vo {
namespace {

constexpr int kSide = 40;           // [px] of the canvas: the largest window, differences, padding
constexpr int kMiddle = kSide / 2;  // the patch's centre, a whole pixel: nothing is resampled twice
constexpr double kMaxStretch = 3.0;        // between target and source, along any direction
constexpr double kCoarsePrecision = 0.03;  // [px] where a finer level follows

float bilinear(const ImagePyramid::Level& level, double x, double y) {
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const auto fx = static_cast<float>(x - x0);
  const auto fy = static_cast<float>(y - y0);
  const float* p = level.at(x0, y0);
  const float* q = p + level.stride;
  return (1.0F - fy) * ((1.0F - fx) * p[0] + fx * p[1]) + fy * ((1.0F - fx) * q[0] + fx * q[1]);
}

bool sensible(const Eigen::Matrix2d& A) {
  if (!A.allFinite() || !(A.determinant() > 0.0)) return false;
  const double square = A.squaredNorm();  // s1^2 + s2^2
  const double root =
      std::sqrt(std::max(0.0, square * square - 4.0 * std::pow(A.determinant(), 2)));
  const double largest = std::sqrt(0.5 * (square + root));
  const double smallest = A.determinant() / largest;
  return largest < kMaxStretch && smallest > 1.0 / kMaxStretch;
}

bool inside(const ImagePyramid::Level& level, const Eigen::Vector2d& p, double half) {
  return p.x() >= half && p.y() >= half && p.x() <= level.width - 1 - half &&
         p.y() <= level.height - 1 - half;
}

}  // namespace

bool take_warped(const ImagePyramid& source,
                 const PatchWarp& warp,
                 int target_level,
                 int window,
                 PatchTemplate& patch) {
  if (!sensible(warp.A_target_source)) return false;
  const Eigen::Matrix2d A_source_target = warp.A_target_source.inverse();
  const double stretch = std::sqrt(A_source_target.determinant());
  const int last = static_cast<int>(source.levels().size()) - 1;
  const int source_level =
      std::clamp(target_level + static_cast<int>(std::lround(std::log2(stretch))), 0, last);
  const ImagePyramid::Level& level = source[source_level];

  const double source_scale = 1.0 / static_cast<double>(1 << source_level);
  const Eigen::Matrix2d step =
      A_source_target * (static_cast<double>(1 << target_level) * source_scale);
  const Eigen::Vector2d center = warp.center * source_scale;
  const int reach = window / 2 + 1;  // one more for the differences
  // The border is a mirror: a little of it does no harm, much of it is not the scene.
  const double half = step.cwiseAbs().rowwise().sum().maxCoeff() * reach;
  if (half > 28.0 || !inside(level, center, 0.0)) return false;

  std::array<float, static_cast<std::size_t>(kSide) * kSide> canvas{};
  for (int y = -reach; y <= reach; ++y) {
    float* row = &canvas[static_cast<std::size_t>((kMiddle + y) * kSide)];
    for (int x = -reach; x <= reach; ++x) {
      const Eigen::Vector2d p = center + step * Eigen::Vector2d(x, y);
      row[kMiddle + x] = bilinear(level, p.x(), p.y());
    }
  }
  ImagePyramid::Level drawn;
  drawn.width = drawn.height = drawn.stride = kSide;
  drawn.pixels = canvas.data();
  return patch.take(drawn, Eigen::Vector2d::Constant(kMiddle), window);
}

Alignment align_warped(const ImagePyramid& source,
                       const PatchWarp& warp,
                       const ImagePyramid& target,
                       const Eigen::Vector2d& start,
                       int coarsest_level,
                       int finest_level,
                       const AlignOptions& options) {
  const int last = static_cast<int>(target.levels().size()) - 1;
  Eigen::Vector2d position = start;
  PatchTemplate patch;
  Alignment result;
  for (int level = std::min(coarsest_level, last); level >= finest_level; --level) {
    const bool finest = level == finest_level;
    const double scale = 1.0 / static_cast<double>(1 << level);
    if (!take_warped(source, warp, level, options.window, patch)) {
      if (finest) return {};
      continue;
    }
    AlignOptions level_options = options;
    if (!finest) level_options.precision = std::max(options.precision, kCoarsePrecision);
    result = patch.align(target[level], position * scale, level_options, false);
    if (result.found) {
      position = result.position / scale;
    } else if (finest) {
      return {};
    }
    if (finest) result.covariance /= scale * scale;
  }
  result.position = position;
  result.found = result.found && inside(target[0], position, 0.5 * (options.window - 1));
  return result;
}

}  // namespace imslam::vo

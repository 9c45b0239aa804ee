#include "tools/bench/matching/warp_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/bench/matching/quality.hpp"

namespace imslam::bench {
namespace {

constexpr int kStride = 2;  // [px] between the pixels that are looked at

/// NaN outside of the image.
double bilinear(const training::Triplet& t, const std::vector<float>& view, double u, double v) {
  const double left = std::floor(u);
  const double top = std::floor(v);
  if (!(left >= 0.0 && top >= 0.0 && left < t.camera.width - 1 && top < t.camera.height - 1)) {
    return NAN;
  }
  const std::size_t at = t.index(static_cast<int>(top), static_cast<int>(left));
  const auto row = static_cast<std::size_t>(t.camera.width);
  const double fx = u - left;
  const double upper = view[at] + fx * (view[at + 1] - view[at]);
  const double lower = view[at + row] + fx * (view[at + row + 1] - view[at + row]);
  return upper + (v - top) * (lower - upper);
}

}  // namespace

WarpCheck check_by_warping(const std::vector<MatchScene>& scenes, vo::MatchKind kind) {
  constexpr std::array<std::array<double, 2>, 5> kErrors{
      {{0.0, 0.0}, {1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}}};
  WarpCheck check;
  std::array<std::vector<double>, 6> residuals;
  for (const MatchScene& scene : scenes) {
    if (!scene.has(kind)) continue;
    ++check.scenes;
    const training::Triplet& t = scene.views;
    const std::vector<float>& other = matched_view(scene, kind);
    for (int row = 0; row < t.camera.height; row += kStride) {
      for (int column = 0; column < t.camera.width; column += kStride) {
        const TrueMatch match = true_match(scene, kind, row, column);
        if (match.state != training::MatchState::kVisible) continue;
        const std::size_t at = t.index(row, column);
        for (std::size_t i = 0; i < kErrors.size(); ++i) {
          const double grey =
              bilinear(t, other, column + match.du + kErrors[i][0], row + match.dv + kErrors[i][1]);
          if (std::isfinite(grey)) residuals[i].push_back(std::abs(grey - double{t.left0[at]}));
        }
        residuals[5].push_back(std::abs(double{other[at]} - double{t.left0[at]}));
      }
    }
  }
  check.points = residuals[0].size();
  check.truth = median(residuals[0]);
  check.one_pixel = std::min(
      {median(residuals[1]), median(residuals[2]), median(residuals[3]), median(residuals[4])});
  check.no_motion = median(residuals[5]);
  return check;
}

}  // namespace imslam::bench

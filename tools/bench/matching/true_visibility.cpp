#include "tools/bench/matching/true_visibility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace imslam::bench {
namespace {

using training::MatchState;

/// What lands in one pixel of the other view.
struct Landing {
  float nearest = -1.0F;  ///< disparity [px]
  float du = 0.0F, dv = 0.0F;
  float least_u = std::numeric_limits<float>::max();
  float least_v = std::numeric_limits<float>::max();
  float most_u = std::numeric_limits<float>::lowest();
  float most_v = std::numeric_limits<float>::lowest();

  void add(const TrueMatch& match, float nearness) {
    const auto u = static_cast<float>(match.du);
    const auto v = static_cast<float>(match.dv);
    if (nearness > nearest) {
      nearest = nearness;
      du = u;
      dv = v;
    }
    least_u = std::min(least_u, u);
    least_v = std::min(least_v, v);
    most_u = std::max(most_u, u);
    most_v = std::max(most_v, v);
  }

  bool hides(const TrueMatch& match, float nearness) const {
    return nearest > nearness &&
           std::hypot(double{du} - match.du, double{dv} - match.dv) > kSameSurface;
  }
  bool doubtful(const TrueMatch& match) const {
    return std::max({double{most_u} - match.du, match.du - double{least_u},
                     double{most_v} - match.dv, match.dv - double{least_v}}) > kSameSurface;
  }
};

class Landings {
 public:
  Landings(int width, int height)
      : width_(width),
        height_(height),
        cells_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  bool contains(double u, double v) const {
    return u >= 0.0 && v >= 0.0 && u <= width_ - 1 && v <= height_ - 1;
  }

  /// The four pixels around a place inside the view; at its border some are the same.
  std::array<Landing*, 4> around(double u, double v) {
    const int left = static_cast<int>(u);
    const int top = static_cast<int>(v);
    const int right = std::min(left + 1, width_ - 1);
    const int bottom = std::min(top + 1, height_ - 1);
    return {cell(top, left), cell(top, right), cell(bottom, left), cell(bottom, right)};
  }

 private:
  Landing* cell(int row, int column) {
    return &cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(column)];
  }

  int width_, height_;
  std::vector<Landing> cells_;
};

}  // namespace

void mark_hidden(vo::MatchKind kind, MatchScene& scene) {
  training::Triplet& t = scene.views;
  std::vector<MatchState>& states = kind == vo::MatchKind::kFlow ? t.flow_state : t.disparity_state;
  Landings landings(t.camera.width, t.camera.height);
  const auto for_each_visible = [&](const auto& body) {
    for (int row = 0; row < t.camera.height; ++row) {
      for (int column = 0; column < t.camera.width; ++column) {
        const TrueMatch match = true_match(scene, kind, row, column);
        if (match.state == MatchState::kVisible) body(t.index(row, column), row, column, match);
      }
    }
  };
  for_each_visible([&](std::size_t at, int row, int column, const TrueMatch& match) {
    const double u = column + match.du;
    const double v = row + match.dv;
    if (!landings.contains(u, v)) {
      states[at] = MatchState::kOutside;
      return;
    }
    for (Landing* landing : landings.around(u, v)) landing->add(match, t.disparity[at]);
  });
  const bool depth_known = scene.has_stereo;
  for_each_visible([&](std::size_t at, int row, int column, const TrueMatch& match) {
    for (const Landing* landing : landings.around(column + match.du, row + match.dv)) {
      const bool hidden =
          depth_known ? landing->hides(match, t.disparity[at]) : landing->doubtful(match);
      if (hidden) states[at] = MatchState::kHidden;
    }
  });
}

}  // namespace imslam::bench

#include "slam/training/occluders.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"

namespace imslam::training {
namespace {

/// An occluder in one view.
struct Box {
  double left, top, right, bottom;

  bool contains(double u, double v) const {
    return u >= left && u <= right && v >= top && v <= bottom;
  }
};

Box box_at(const Occluder& occluder, double move_u, double move_v) {
  const double left = occluder.x + move_u;
  const double top = occluder.y + move_v;
  return {left, top, left + occluder.width, top + occluder.height};
}

/// Length of the part of the pixel about `centre` that lies in [low, high].
double overlap(double centre, double low, double high) {
  return std::max(0.0, std::min(centre + 0.5, high) - std::max(centre - 0.5, low));
}

struct PixelRange {
  int first, last;  ///< both included; last < first: none
};

PixelRange touched(double low, double high, int size) {
  return {static_cast<int>(std::clamp(std::floor(low + 0.5), 0.0, static_cast<double>(size))),
          static_cast<int>(std::clamp(std::floor(high + 0.5), -1.0, size - 1.0))};
}

void draw(const Box& box, float grey, const Triplet& triplet, std::vector<float>& image) {
  const PixelRange rows = touched(box.top, box.bottom, triplet.camera.height);
  const PixelRange columns = touched(box.left, box.right, triplet.camera.width);
  for (int row = rows.first; row <= rows.last; ++row) {
    const double height = overlap(row, box.top, box.bottom);
    for (int column = columns.first; column <= columns.last; ++column) {
      const double share = height * overlap(column, box.left, box.right);
      float& pixel = image[triplet.index(row, column)];
      pixel += static_cast<float>(share) * (grey - pixel);
    }
  }
}

/// The matches of one displacement field after the occluders have moved in. `from`: the boxes in
/// left0, `to`: in the other view.
class Cover {
 public:
  Cover(std::vector<Box> from, std::vector<Box> to, int width, int height)
      : from_(std::move(from)), to_(std::move(to)), width_(width), height_(height) {}

  /// The topmost box over a pixel of left0; -1: none.
  int over(double u, double v) const {
    for (std::size_t i = from_.size(); i-- > 0;)
      if (from_[i].contains(u, v)) return static_cast<int>(i);
    return -1;
  }

  /// `own`: the box that the point lies on; -1: the scene.
  MatchState state(double u, double v, int own, MatchState before) const {
    if (!(u >= 0.0 && v >= 0.0 && u <= width_ - 1 && v <= height_ - 1)) return before;
    for (std::size_t i = static_cast<std::size_t>(own + 1); i < to_.size(); ++i)
      if (to_[i].contains(u, v)) return MatchState::kHidden;
    return before;
  }

  MatchState own_state(double u, double v, int own) const {
    if (!(u >= 0.0 && v >= 0.0 && u <= width_ - 1 && v <= height_ - 1)) return MatchState::kOutside;
    return state(u, v, own, MatchState::kVisible);
  }

 private:
  std::vector<Box> from_, to_;
  int width_, height_;
};

/// Corrects the truth of one pixel of left0.
void cover_truth(const std::vector<Occluder>& occluders,
                 const Cover& in_right0,
                 const Cover& in_left1,
                 int row,
                 int column,
                 Triplet& t) {
  const std::size_t at = t.index(row, column);
  const int own = in_right0.over(column, row);
  if (own >= 0) {
    const Occluder& occluder = occluders[static_cast<std::size_t>(own)];
    t.disparity[at] = static_cast<float>(occluder.disparity);
    t.flow_u[at] = static_cast<float>(occluder.flow_u);
    t.flow_v[at] = static_cast<float>(occluder.flow_v);
    t.disparity_state[at] = in_right0.own_state(column - occluder.disparity, row, own);
    t.flow_state[at] = in_left1.own_state(column + occluder.flow_u, row + occluder.flow_v, own);
    return;
  }
  const double u = column - double{t.disparity[at]};
  t.disparity_state[at] = in_right0.state(u, row, own, t.disparity_state[at]);
  if (t.flow_state[at] == MatchState::kNone) return;
  t.flow_state[at] = in_left1.state(column + double{t.flow_u[at]}, row + double{t.flow_v[at]}, own,
                                    t.flow_state[at]);
}

}  // namespace

void add_occluders(const std::vector<Occluder>& occluders, Triplet& triplet) {
  if (occluders.empty()) return;
  std::vector<Box> left0;
  std::vector<Box> right0;
  std::vector<Box> left1;
  for (const Occluder& occluder : occluders) {
    expects(occluder.disparity > 0.0, "add_occluders: disparity must be positive");
    left0.push_back(box_at(occluder, 0.0, 0.0));
    right0.push_back(box_at(occluder, -occluder.disparity, 0.0));
    left1.push_back(box_at(occluder, occluder.flow_u, occluder.flow_v));
    draw(left0.back(), occluder.grey, triplet, triplet.left0);
    draw(right0.back(), occluder.grey, triplet, triplet.right0);
    draw(left1.back(), occluder.grey, triplet, triplet.left1);
  }
  const Cover in_right0(left0, right0, triplet.camera.width, triplet.camera.height);
  const Cover in_left1(left0, left1, triplet.camera.width, triplet.camera.height);
  for (int row = 0; row < triplet.camera.height; ++row) {
    for (int column = 0; column < triplet.camera.width; ++column)
      cover_truth(occluders, in_right0, in_left1, row, column, triplet);
  }
}

}  // namespace imslam::training

#pragma once

#include <algorithm>

namespace imslam::nn::kernels {

/// Cuts the cells of one axis into intervals: one at each edge if asked, the others of almost equal
/// length.
class AxisCuts {
 public:
  AxisCuts() = default;
  /// `edge` cells (perhaps 0) at both ends, between them intervals of at most `most`. Without room
  /// for that the edges are not set apart.
  AxisCuts(int cells, int edge, int most) : cells_(cells) {
    if (cells >= 3 * edge) edge_ = edge;
    const int inner = cells_ - 2 * edge_;
    inner_count_ = (inner + std::max(1, most) - 1) / std::max(1, most);
  }

  int count() const { return inner_count_ + (edge_ > 0 ? 2 : 0); }
  int begin(int index) const {
    if (edge_ == 0) return inner_begin(index);
    if (index == 0) return 0;
    return index == count() ? cells_ : edge_ + inner_begin(index - 1);
  }
  int longest() const { return std::max(edge_, (cells_ - 2 * edge_ - 1) / inner_count_ + 1); }

 private:
  int inner_begin(int index) const {
    const int inner = cells_ - 2 * edge_;
    return index * (inner / inner_count_) + std::min(index, inner % inner_count_);
  }

  int cells_ = 1;
  int edge_ = 0;
  int inner_count_ = 1;
};

}  // namespace imslam::nn::kernels

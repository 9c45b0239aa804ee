#include "slam/nn/ops/broadcast.hpp"

#include <algorithm>

#include "slam/base/error.hpp"

namespace imslam::nn {
namespace {

/// Size along the axis that is `back` places before the last; 1 where the axis is missing.
Index size_from_back(const Shape& shape, int back) {
  return back < shape.rank() ? shape[shape.rank() - 1 - back] : 1;
}

}  // namespace

Shape broadcast_shape(const Shape& a, const Shape& b) {
  const int rank = std::max(a.rank(), b.rank());
  std::array<Index, Shape::kMaxRank> sizes{};
  for (int back = 0; back < rank; ++back) {
    const Index n = size_from_back(a, back);
    const Index m = size_from_back(b, back);
    expects_shapes(n == m || n == 1 || m == 1, "broadcast: sizes must agree or be 1", a, b);
    sizes[static_cast<std::size_t>(rank - 1 - back)] = n == 1 ? m : n;
  }
  return {sizes.data(), rank};
}

BroadcastLoop::BroadcastLoop(const Shape& full, const Shape& a, const Shape& b) {
  Index stride_a = 1;
  Index stride_b = 1;
  for (int back = 0; back < Shape::kMaxRank; ++back) {
    const std::size_t axis = kAxes - 1 - static_cast<std::size_t>(back);
    const Index n = size_from_back(a, back);
    const Index m = size_from_back(b, back);
    sizes_[axis] = size_from_back(full, back);
    strides_a_[axis] = n == 1 ? 0 : stride_a;
    strides_b_[axis] = m == 1 ? 0 : stride_b;
    stride_a *= n;
    stride_b *= m;
  }
  merge_axes();
}

void BroadcastLoop::merge_axes() {
  std::size_t row = kAxes - 1;
  for (std::size_t axis = kAxes - 1; axis-- > 0;) {
    if (sizes_[axis] == 1) continue;
    if (sizes_[row] == 1) {
      sizes_[row] = sizes_[axis];
      strides_a_[row] = strides_a_[axis];
      strides_b_[row] = strides_b_[axis];
    } else if (strides_a_[axis] == strides_a_[row] * sizes_[row] &&
               strides_b_[axis] == strides_b_[row] * sizes_[row]) {
      sizes_[row] *= sizes_[axis];
    } else {
      --row;
      sizes_[row] = sizes_[axis];
      strides_a_[row] = strides_a_[axis];
      strides_b_[row] = strides_b_[axis];
    }
  }
  for (std::size_t axis = 0; axis < row; ++axis) {
    sizes_[axis] = 1;
    strides_a_[axis] = strides_b_[axis] = 0;
  }
}

}  // namespace imslam::nn

#pragma once

#include <array>

#include "slam/nn/shape.hpp"

namespace imslam::nn {

/// The shape that two operands share: sizes are compared from the last axis on; a size of 1 (or a
/// missing axis) is repeated. [N,H,W,C] and [C] -> [N,H,W,C];  [N,1,3] and [5,1] -> [N,5,3].
/// Throws ContractError if the sizes differ otherwise.
Shape broadcast_shape(const Shape& a, const Shape& b);

/// Walks a shape row by row together with two operands that are repeated along some axes.
///
/// Strides are 0 along repeated axes; neighbouring axes that both operands walk in the same way are
/// merged, so equal shapes are one long row.
class BroadcastLoop {
 public:
  BroadcastLoop(const Shape& full, const Shape& a, const Shape& b);

  /// row(offset, offset_a, offset_b) for each row of `length` numbers.
  template <typename Row>
  void for_each_row(const Row& row) const {
    Index offset = 0;
    for (Index i = 0; i < size(0); ++i) {
      for (Index j = 0; j < size(1); ++j) {
        for (Index k = 0; k < size(2); ++k) {
          for (Index l = 0; l < size(3); ++l) {
            row(offset, i * a(0) + j * a(1) + k * a(2) + l * a(3),
                i * b(0) + j * b(1) + k * b(2) + l * b(3));
            offset += length();
          }
        }
      }
    }
  }

  Index length() const { return size(4); }
  Index step_a() const { return a(4); }  ///< along a row: 0 or 1
  Index step_b() const { return b(4); }

 private:
  static constexpr std::size_t kAxes = Shape::kMaxRank;

  void merge_axes();
  Index size(std::size_t axis) const { return sizes_[axis]; }
  Index a(std::size_t axis) const { return strides_a_[axis]; }
  Index b(std::size_t axis) const { return strides_b_[axis]; }

  // Right-aligned: axis 4 is the row, unused axes in front have size 1.
  std::array<Index, kAxes> sizes_{};
  std::array<Index, kAxes> strides_a_{};
  std::array<Index, kAxes> strides_b_{};
};

}  // namespace imslam::nn

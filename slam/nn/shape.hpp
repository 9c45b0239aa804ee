#pragma once

#include <Eigen/Core>
#include <array>
#include <initializer_list>
#include <string>

namespace imslam::nn {

using Index = Eigen::Index;  ///< 64-bit, signed

/// The sizes of a tensor, row-major: the last dimension is contiguous.
///
///   [N,H,W,C] images    [N,T,C] sequences    [N,C] or [C] features    the last one is "channels"
///   size = product of all    rows = size / channels    [] is one number
///
/// Sizes may be zero (no query points in a dark frame). A product beyond 2^62 is a ContractError.
class Shape {
 public:
  static constexpr int kMaxRank = 5;

  Shape() = default;
  Shape(std::initializer_list<Index> sizes);
  Shape(const Index* sizes, int rank);

  int rank() const { return rank_; }
  Index size() const { return size_; }
  Index channels() const { return rank_ == 0 ? 1 : sizes_[static_cast<std::size_t>(rank_ - 1)]; }
  Index rows() const;

  /// Size along `axis`; negative axes count from the end.
  Index operator[](int axis) const { return sizes_[static_cast<std::size_t>(axis_of(axis))]; }

  /// 0 <= result < rank; negative axes count from the end.
  int axis_of(int axis) const;

  Shape with(int axis, Index size) const;     ///< one size replaced
  Shape with_channels(Index channels) const;  ///< the last size replaced
  Shape without(int axis) const;

  std::string text() const;  ///< "[2,3,4]"

  bool operator==(const Shape& other) const;
  bool operator!=(const Shape& other) const { return !(*this == other); }

 private:
  std::array<Index, kMaxRank> sizes_{};
  int rank_ = 0;
  Index size_ = 1;
};

/// Throws ContractError "what: [2,3] and [4]" unless `ok`.
void expects_shapes(bool ok, const char* what, const Shape& a, const Shape& b);
/// Throws ContractError "what: [2,3]" unless `ok`.
void expects_shape(bool ok, const char* what, const Shape& shape);

}  // namespace imslam::nn

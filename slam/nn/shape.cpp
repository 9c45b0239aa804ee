#include "slam/nn/shape.hpp"

#include "slam/base/error.hpp"

namespace imslam::nn {
namespace {

constexpr Index kLargestSize = Index{1} << 62;

}  // namespace

Shape::Shape(std::initializer_list<Index> sizes)
    : Shape(sizes.begin(), static_cast<int>(sizes.size())) {}

Shape::Shape(const Index* sizes, int rank) : rank_(rank) {
  expects(rank >= 0 && rank <= kMaxRank, "Shape: at most 5 dimensions");
  for (int axis = 0; axis < rank; ++axis) {
    const Index n = sizes[axis];
    expects(n >= 0, "Shape: a size must not be negative");
    expects(n == 0 || size_ <= kLargestSize / n, "Shape: the product of the sizes overflows");
    sizes_[static_cast<std::size_t>(axis)] = n;
    size_ *= n;
  }
}

Index Shape::rows() const {
  Index product = 1;
  for (int axis = 0; axis + 1 < rank_; ++axis) product *= sizes_[static_cast<std::size_t>(axis)];
  return product;
}

int Shape::axis_of(int axis) const {
  const int positive = axis < 0 ? axis + rank_ : axis;
  expects_shape(positive >= 0 && positive < rank_, "Shape: no such axis", *this);
  return positive;
}

Shape Shape::with(int axis, Index size) const {
  std::array<Index, kMaxRank> sizes = sizes_;
  sizes[static_cast<std::size_t>(axis_of(axis))] = size;
  return {sizes.data(), rank_};
}

Shape Shape::with_channels(Index channels) const { return with(-1, channels); }

Shape Shape::without(int axis) const {
  const int gone = axis_of(axis);
  std::array<Index, kMaxRank> sizes{};
  std::size_t kept = 0;
  for (int i = 0; i < rank_; ++i) {
    if (i != gone) sizes[kept++] = sizes_[static_cast<std::size_t>(i)];
  }
  return {sizes.data(), rank_ - 1};
}

std::string Shape::text() const {
  std::string text = "[";
  for (int axis = 0; axis < rank_; ++axis) {
    if (axis > 0) text += ',';
    text += std::to_string(sizes_[static_cast<std::size_t>(axis)]);
  }
  return text + "]";
}

bool Shape::operator==(const Shape& other) const {
  return rank_ == other.rank_ && sizes_ == other.sizes_;
}

void expects_shapes(bool ok, const char* what, const Shape& a, const Shape& b) {
  if (!ok) throw ContractError(std::string(what) + ": " + a.text() + " and " + b.text());
}

void expects_shape(bool ok, const char* what, const Shape& shape) {
  if (!ok) throw ContractError(std::string(what) + ": " + shape.text());
}

}  // namespace imslam::nn

#include "slam/nn/ops/layout.hpp"

#include "slam/nn/ops/arithmetic.hpp"

namespace imslam::nn {
namespace {

/// A tensor seen as [outer, size, inner] around one axis: moving along it means moving blocks.
struct AxisView {
  AxisView(const Shape& shape, int axis) : size(shape[axis]) {
    for (int i = 0; i < shape.axis_of(axis); ++i) outer *= shape[i];
    for (int i = shape.axis_of(axis) + 1; i < shape.rank(); ++i) inner *= shape[i];
  }
  Index outer = 1;
  Index size;
  Index inner = 1;
};

/// block(p, q, count) for each run of `length` steps of the axis that is contiguous in both
/// tensors: p, q are its offsets in `part`, which holds steps [0, length), and in `whole`, from
/// `start` on.
template <typename Block>
void for_each_block(const AxisView& part, const AxisView& whole, Index start, const Block& block) {
  const Index count = part.size * part.inner;
  for (Index i = 0; i < part.outer; ++i) {
    block(i * count, (i * whole.size + start) * whole.inner, count);
  }
}

/// Strides of x in the order of the axes of y, right-aligned in five loops.
struct Permutation {
  std::array<Index, Shape::kMaxRank> sizes{1, 1, 1, 1, 1};
  std::array<Index, Shape::kMaxRank> strides{};

  /// visit(at_y, at_x) for all numbers; at_y counts up.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    Index at = 0;
    for (Index a = 0; a < sizes[0]; ++a) {
      for (Index b = 0; b < sizes[1]; ++b) {
        for (Index c = 0; c < sizes[2]; ++c) {
          for (Index d = 0; d < sizes[3]; ++d) {
            Index from = a * strides[0] + b * strides[1] + c * strides[2] + d * strides[3];
            for (Index e = 0; e < sizes[4]; ++e, from += strides[4]) visit(at++, from);
          }
        }
      }
    }
  }
};

/// Fills `sizes` with those of y.
Permutation permutation_of(const Shape& x, const int* axes, int rank, Index* sizes) {
  expects_shape(rank == x.rank(), "permute: one axis of x for each axis of y", x);
  std::array<Index, Shape::kMaxRank> strides{};
  Index stride = 1;
  for (int axis = rank - 1; axis >= 0; --axis) {
    strides[static_cast<std::size_t>(axis)] = stride;
    stride *= x[axis];
  }
  Permutation permutation;
  unsigned seen = 0;
  for (int i = 0; i < rank; ++i) {
    const int axis = x.axis_of(axes[i]);
    const auto place = static_cast<std::size_t>(Shape::kMaxRank - rank + i);
    permutation.sizes[place] = sizes[i] = x[axis];
    permutation.strides[place] = strides[static_cast<std::size_t>(axis)];
    seen |= 1U << static_cast<unsigned>(axis);
  }
  expects_shape(seen == (1U << static_cast<unsigned>(rank)) - 1U, "permute: each axis once", x);
  return permutation;
}

template <typename S>
Var concat_parts(Tape<S>& tape, const Var* parts, std::size_t count, int axis) {
  expects(count > 0, "concat: one part or more");
  const Shape first = tape.shape(parts[0]);
  Index total = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Shape part = tape.shape(parts[i]);
    expects_shapes(part.rank() == first.rank() && part.with(axis, 0) == first.with(axis, 0),
                   "concat: all sizes but one agree", first, part);
    total += part[axis];
  }
  const Var y = tape.make(first.with(axis, total));
  const AxisView whole(tape.shape(y), axis);
  S* const Y = tape.data(y);
  Var* const kept = tape.template keep<Var>(static_cast<Index>(count));
  Index start = 0;
  for (std::size_t i = 0; i < count; ++i) {
    kept[i] = parts[i];
    const AxisView part(tape.shape(parts[i]), axis);
    const S* const X = tape.data(parts[i]);
    for_each_block(part, whole, start,
                   [&](Index p, Index q, Index n) { std::copy_n(X + p, n, Y + q); });
    start += part.size;
  }
  return tape.record(y, parts, count, [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    Index at = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const AxisView part(t.shape(kept[i]), axis);
      t.accumulate(kept[i], [&](ArrayMap<S> dX) {
        for_each_block(part, whole, at, [&](Index p, Index q, Index n) {
          for (Index k = 0; k < n; ++k) dX[p + k] += dY[q + k];
        });
      });
      at += part.size;
    }
  });
}

}  // namespace

template <typename S>
Var reshape(Tape<S>& tape, Var x, const Shape& shape) {
  const Var y = tape.alias(x, shape);
  return tape.record(y, {x}, [x, y](Tape<S>& t) { t.pass_on(y, x); });
}

template <typename S>
Var permute(Tape<S>& tape, Var x, const int* axes, int rank) {
  std::array<Index, Shape::kMaxRank> sizes{};
  const Permutation permutation = permutation_of(tape.shape(x), axes, rank, sizes.data());
  const Var y = tape.make({sizes.data(), rank});
  const S* const X = tape.data(x);
  S* const Y = tape.data(y);
  permutation.for_each([&](Index at_y, Index at_x) { Y[at_y] = X[at_x]; });
  return tape.record(y, {x}, [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    S* const dX = t.gradient_data(x);
    permutation.for_each([&](Index at_y, Index at_x) { dX[at_x] += dY[at_y]; });
  });
}

template <typename S>
Var permute(Tape<S>& tape, Var x, std::initializer_list<int> axes) {
  return permute(tape, x, axes.begin(), static_cast<int>(axes.size()));
}

template <typename S>
Var slice(Tape<S>& tape, Var x, int axis, Index start, Index length) {
  const Shape of_x = tape.shape(x);
  expects_shape(start >= 0 && length >= 0 && start + length <= of_x[axis],
                "slice: start and length inside of the axis", of_x);
  const Shape of_y = of_x.with(axis, length);
  const AxisView whole(of_x, axis);
  const AxisView part(of_y, axis);
  const Var y = tape.make(of_y);
  const S* const X = tape.data(x);
  S* const Y = tape.data(y);
  for_each_block(part, whole, start,
                 [&](Index p, Index q, Index count) { std::copy_n(X + q, count, Y + p); });
  return tape.record(y, {x}, [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    S* const dX = t.gradient_data(x);
    for_each_block(part, whole, start, [&](Index p, Index q, Index count) {
      for (Index i = 0; i < count; ++i) dX[q + i] += dY[p + i];
    });
  });
}

template <typename S>
Var pad(Tape<S>& tape, Var x, int axis, Index before, Index after) {
  const Shape of_x = tape.shape(x);
  expects_shape(before >= 0 && after >= 0, "pad: widths of zero or more", of_x);
  const Shape of_y = of_x.with(axis, before + of_x[axis] + after);
  const AxisView part(of_x, axis);
  const AxisView whole(of_y, axis);
  const Var y = tape.make(of_y);
  const S* const X = tape.data(x);
  S* const Y = tape.data(y);
  std::fill_n(Y, of_y.size(), S(0));
  for_each_block(part, whole, before,
                 [&](Index p, Index q, Index count) { std::copy_n(X + p, count, Y + q); });
  return tape.record(y, {x}, [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    S* const dX = t.gradient_data(x);
    for_each_block(part, whole, before, [&](Index p, Index q, Index count) {
      for (Index i = 0; i < count; ++i) dX[p + i] += dY[q + i];
    });
  });
}

template <typename S>
Var concat(Tape<S>& tape, std::initializer_list<Var> parts, int axis) {
  return concat_parts(tape, parts.begin(), parts.size(), axis);
}

template <typename S>
Var concat(Tape<S>& tape, const std::vector<Var>& parts, int axis) {
  return concat_parts(tape, parts.data(), parts.size(), axis);
}

template <typename S>
Var expand(Tape<S>& tape, Var x, const Shape& shape) {
  const Var zeros = tape.make(shape);
  tape.array(zeros) = S(0);
  return add(tape, x, zeros);
}

#define INSTANTIATE(S)                                             \
  template Var reshape(Tape<S>&, Var, const Shape&);               \
  template Var permute(Tape<S>&, Var, std::initializer_list<int>); \
  template Var permute(Tape<S>&, Var, const int*, int);            \
  template Var slice(Tape<S>&, Var, int, Index, Index);            \
  template Var pad(Tape<S>&, Var, int, Index, Index);              \
  template Var concat(Tape<S>&, std::initializer_list<Var>, int);  \
  template Var concat(Tape<S>&, const std::vector<Var>&, int);     \
  template Var expand(Tape<S>&, Var, const Shape&);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn

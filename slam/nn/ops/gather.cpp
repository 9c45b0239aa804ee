#include "slam/nn/ops/gather.hpp"

namespace imslam::nn {
namespace {

/// A copy of the indices that lives as long as the tape's values.
template <typename S>
const std::int32_t* kept(Tape<S>& tape, const std::vector<std::int32_t>& indices) {
  std::int32_t* const copy = tape.template keep<std::int32_t>(static_cast<Index>(indices.size()));
  std::copy(indices.begin(), indices.end(), copy);
  return copy;
}

void expect_indices(const std::vector<std::int32_t>& indices, Index low, Index end) {
  for (const std::int32_t i : indices) expects(i >= low && i < end, "gather: index out of range");
}

/// to[target(k)] += from[source(k)], row by row.
template <typename S, typename Source, typename Target>
void add_rows(Index count, Index width, const S* from, S* to, Source source, Target target) {
  for (Index k = 0; k < count; ++k) {
    if (source(k) < 0 || target(k) < 0) continue;
    const S* const p = from + source(k) * width;
    S* const q = to + target(k) * width;
    for (Index i = 0; i < width; ++i) q[i] += p[i];
  }
}

Index width_of(const Shape& x) {
  expects_shape(x.rank() >= 1, "gather: at least one axis", x);
  Index width = 1;
  for (int axis = 1; axis < x.rank(); ++axis) width *= x[axis];
  return width;
}

constexpr auto kSame = [](Index k) { return k; };

}  // namespace

template <typename S>
Var gather(Tape<S>& tape, Var x, const std::vector<std::int32_t>& indices) {
  const Shape of_x = tape.shape(x);
  const Index width = width_of(of_x);
  const auto count = static_cast<Index>(indices.size());
  expect_indices(indices, -1, of_x[0]);
  const std::int32_t* const rows = kept(tape, indices);
  const auto row = [rows](Index k) { return static_cast<Index>(rows[k]); };
  const Var y = tape.make(of_x.with(0, count));
  tape.array(y) = S(0);
  add_rows(count, width, tape.data(x), tape.data(y), row, kSame);
  return tape.record(y, {x}, [=](Tape<S>& t) {
    add_rows(count, width, t.gradient_data(y), t.gradient_data(x), kSame, row);
  });
}

template <typename S>
Var scatter_add(Tape<S>& tape, Var x, const std::vector<std::int32_t>& indices, Index rows) {
  const Shape of_x = tape.shape(x);
  const Index width = width_of(of_x);
  const auto count = static_cast<Index>(indices.size());
  expects_shape(of_x[0] == count, "scatter_add: one index per row", of_x);
  expect_indices(indices, -1, rows);
  const std::int32_t* const targets = kept(tape, indices);
  const auto row = [targets](Index k) { return static_cast<Index>(targets[k]); };
  const Var y = tape.make(of_x.with(0, rows));
  tape.array(y) = S(0);
  add_rows(count, width, tape.data(x), tape.data(y), kSame, row);
  return tape.record(y, {x}, [=](Tape<S>& t) {
    add_rows(count, width, t.gradient_data(y), t.gradient_data(x), row, kSame);
  });
}

template <typename S>
Var pick(Tape<S>& tape, Var x, const std::vector<std::int32_t>& channels) {
  const Shape of_x = tape.shape(x);
  expects_shape(of_x.rank() >= 1 && of_x.rows() == static_cast<Index>(channels.size()),
                "pick: one channel per row", of_x);
  const Index width = of_x.channels();
  expect_indices(channels, 0, width);
  const std::int32_t* const chosen = kept(tape, channels);
  const Var y = tape.make(of_x.without(-1));
  for (Index r = 0; r < of_x.rows(); ++r) tape.data(y)[r] = tape.data(x)[r * width + chosen[r]];
  return tape.record(y, {x}, [=](Tape<S>& t) {
    const S* const dY = t.gradient_data(y);
    S* const dX = t.gradient_data(x);
    for (Index r = 0; r < t.shape(y).size(); ++r) dX[r * width + chosen[r]] += dY[r];
  });
}

#define INSTANTIATE(S)                                                              \
  template Var gather(Tape<S>&, Var, const std::vector<std::int32_t>&);             \
  template Var scatter_add(Tape<S>&, Var, const std::vector<std::int32_t>&, Index); \
  template Var pick(Tape<S>&, Var, const std::vector<std::int32_t>&);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn

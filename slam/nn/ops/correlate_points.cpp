#include <algorithm>
#include <cmath>
#include <functional>
#include <type_traits>

#include "slam/base/parallel.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "slam/nn/ops/correlation.hpp"

namespace imslam::nn {
namespace {

constexpr double kFarAway = 1e9;      // beyond it a coordinate does not fit into an int
constexpr Index kPointsPerTask = 64;  // fixed: tasks do not depend on the number of threads

template <typename S>
using Row = Eigen::Map<Eigen::Array<S, Eigen::Dynamic, 1>>;
template <typename S>
using ConstRow = Eigen::Map<const Eigen::Array<S, Eigen::Dynamic, 1>>;

/// The window of one point: whole products D on a grid, mixed with parts (u, v) of a pixel.
template <typename S>
struct Placed {
  bool inside = false;  ///< false: the centre is no place at all
  Index x = 0;          ///< whole part of the centre
  Index y = 0;
  S u = S(0);
  S v = S(0);
};

struct PointWindows {
  Index samples, points, height, width, channels;
  Window window;
  Index border;  ///< extra columns and rows of the grid: 1 if bilinear, 0 if rounded

  Index columns() const { return window.columns() + border; }
  Index rows() const { return window.rows() + border; }
  Index grid_size() const { return columns() * rows(); }

  template <typename S>
  Placed<S> place(const S* centre) const {
    Placed<S> p;
    const double x = static_cast<double>(value_of(centre[0]));
    const double y = static_cast<double>(value_of(centre[1]));
    p.inside = std::abs(x) < kFarAway && std::abs(y) < kFarAway;
    if (!p.inside) return p;
    const double rounding = border == 1 ? 0.0 : 0.5;
    p.x = static_cast<Index>(std::floor(x + rounding));
    p.y = static_cast<Index>(std::floor(y + rounding));
    if (border == 0) return p;
    p.u = centre[0] - S(static_cast<double>(p.x));
    p.v = centre[1] - S(static_cast<double>(p.y));
    return p;
  }

  /// visit(g, offset) for the cells of the grid of point i that lie inside of b.
  template <typename S, typename Visit>
  void for_each_cell(Index i, const Placed<S>& p, const Visit& visit) const {
    if (!p.inside) return;
    const Index sample = i / points;
    for (Index r = 0; r < rows(); ++r) {
      const Index row = p.y + window.y_min + r * window.step;
      if (row < 0 || row >= height) continue;
      for (Index c = 0; c < columns(); ++c) {
        const Index column = p.x + window.x_min + c * window.step;
        if (column < 0 || column >= width) continue;
        visit(r * columns() + c, ((sample * height + row) * width + column) * channels);
      }
    }
  }

  /// D[g] = <q, b> for the cells of the grid of point i inside of b; step 1.
  void fill_grid(Index i, const Placed<float>& p, const float* q, const float* B, float* D) const {
    if (!p.inside) return;
    const Index first = std::max<Index>(0, p.x + window.x_min);
    const Index end = std::min(width, p.x + window.x_min + columns());
    for (Index r = 0; r < rows() && first < end; ++r) {
      const Index row = p.y + window.y_min + r;
      if (row < 0 || row >= height) continue;
      const float* const pixels = B + ((i / points * height + row) * width + first) * channels;
      kernels::selected_kernels().dot_products(q, pixels, end - first, static_cast<int>(channels),
                                               D + r * columns() + first - p.x - window.x_min);
    }
  }

  /// visit(k, g): displacement k and the grid cell of its upper left corner.
  template <typename Visit>
  void for_each_displacement(const Visit& visit) const {
    const Index width_of_grid = columns();
    const Index per_row = window.columns();
    const Index height_of_window = window.rows();
    for (Index r = 0; r < height_of_window; ++r) {
      for (Index c = 0; c < per_row; ++c) visit(r * per_row + c, r * width_of_grid + c);
    }
  }
};

template <typename S>
void forward_point(
    const PointWindows& w, Index i, const S* q, const S* B, const S* centre, S* D, S* y) {
  const Placed<S> p = w.place(centre);
  std::fill_n(D, w.grid_size(), S(0));
  const ConstRow<S> query(q, w.channels);
  if constexpr (std::is_same_v<S, float>) {
    if (w.window.step == 1) w.fill_grid(i, p, q, B, D);
  }
  const bool filled = std::is_same_v<S, float> && w.window.step == 1;
  if (!filled) {
    w.for_each_cell(
        i, p, [&](Index g, Index at) { D[g] = (query * ConstRow<S>(B + at, w.channels)).sum(); });
  }
  w.for_each_displacement([&](Index k, Index g) {
    if (w.border == 0) {
      y[k] = D[g];
      return;
    }
    const S* const below = D + g + w.columns();
    y[k] = (S(1) - p.v) * ((S(1) - p.u) * D[g] + p.u * D[g + 1]) +
           p.v * ((S(1) - p.u) * below[0] + p.u * below[1]);
  });
}

/// From dy [K] to dD [grid] and, for bilinear windows, to the centre.
template <typename S>
void unmix(const PointWindows& w, const Placed<S>& p, const S* D, const S* dy, S* dD, S* dcentre) {
  std::fill_n(dD, w.grid_size(), S(0));
  w.for_each_displacement([&](Index k, Index g) {
    if (w.border == 0) {
      dD[g] = dy[k];
      return;
    }
    const Index below = g + w.columns();
    dD[g] += dy[k] * (S(1) - p.u) * (S(1) - p.v);
    dD[g + 1] += dy[k] * p.u * (S(1) - p.v);
    dD[below] += dy[k] * (S(1) - p.u) * p.v;
    dD[below + 1] += dy[k] * p.u * p.v;
    if (dcentre == nullptr || !p.inside) return;
    dcentre[0] += dy[k] * ((S(1) - p.v) * (D[g + 1] - D[g]) + p.v * (D[below + 1] - D[below]));
    dcentre[1] += dy[k] * ((S(1) - p.u) * (D[below] - D[g]) + p.u * (D[below + 1] - D[g + 1]));
  });
}

template <typename S>
void backward(Tape<S>& t, const PointWindows& w, Var query, Var b, Var centres, const S* D, Var y) {
  Scratch<S> scratch(t);
  S* const dD = scratch.template zeros<S>(w.grid_size());
  S* const dQ = t.wants_gradient(query) ? t.gradient_data(query) : nullptr;
  S* const dB = t.wants_gradient(b) ? t.gradient_data(b) : nullptr;
  S* const dP = t.wants_gradient(centres) ? t.gradient_data(centres) : nullptr;
  const Index C = w.channels;
  for (Index i = 0; i < w.samples * w.points; ++i) {
    const Placed<S> p = w.place(t.data(centres) + 2 * i);
    unmix(w, p, D + i * w.grid_size(), t.gradient_data(y) + i * w.window.count(), dD,
          dP == nullptr ? nullptr : dP + 2 * i);
    w.for_each_cell(i, p, [&](Index g, Index at) {
      if (dQ != nullptr) Row<S>(dQ + i * C, C) += dD[g] * ConstRow<S>(t.data(b) + at, C);
      if (dB != nullptr) Row<S>(dB + at, C) += dD[g] * ConstRow<S>(t.data(query) + i * C, C);
    });
  }
}

}  // namespace

template <typename S>
Var correlate_points(
    Tape<S>& tape, Var query, Var b, Var centres, const Window& window, Centre centre) {
  const Shape of_q = tape.shape(query);
  const Shape of_b = tape.shape(b);
  const Shape of_c = tape.shape(centres);
  window.validate();
  expects(centre == Centre::kRounded || window.step == 1,
          "correlate_points: bilinear needs step 1");
  expects_shapes(of_q.rank() == 3 && of_b.rank() == 4 && of_q[0] == of_b[0] && of_q[2] == of_b[3],
                 "correlate_points: query [N,P,C] and b [N,H,W,C]", of_q, of_b);
  expects_shapes(of_c == of_q.with_channels(2), "correlate_points: centres [N,P,2]", of_c, of_q);
  const Index border = centre == Centre::kBilinear ? 1 : 0;
  const PointWindows w{of_q[0], of_q[1], of_b[1], of_b[2], of_b[3], window, border};
  const Index count = w.samples * w.points;
  const Var y = tape.make(of_q.with_channels(window.count()));
  S* const D = tape.template keep<S>(count * w.grid_size());
  const S* const Q = tape.data(query);
  const S* const B = tape.data(b);
  const S* const P = tape.data(centres);
  S* const Y = tape.data(y);
  const auto task = [&](std::size_t chunk) {
    const Index begin = static_cast<Index>(chunk) * kPointsPerTask;
    for (Index i = begin; i < std::min(begin + kPointsPerTask, count); ++i) {
      forward_point(w, i, Q + i * w.channels, B, P + 2 * i, D + i * w.grid_size(),
                    Y + i * w.window.count());
    }
  };
  const Index tasks = (count + kPointsPerTask - 1) / kPointsPerTask;
  parallel_for(static_cast<std::size_t>(tasks), std::cref(task));
  const Var moving = border == 1 ? centres : Var{};
  return tape.record(y, {query, b, moving},
                     [=](Tape<S>& t) { backward(t, w, query, b, centres, D, y); });
}

#define INSTANTIATE(S) \
  template Var correlate_points(Tape<S>&, Var, Var, Var, const Window&, Centre);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn

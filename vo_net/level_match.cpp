#include "vo_net/level_match.hpp"

#include <algorithm>
#include <cstdlib>

#include "slam/nn/ops/product.hpp"
#include "slam/nn/ops/softmax.hpp"

namespace imslam::vo {

using nn::Index;

template <typename S>
nn::Var window_cells(nn::Tape<S>& tape, const nn::Window& window) {
  const nn::Var cells = tape.make({window.count(), 2});
  S* const numbers = tape.data(cells);
  for (int k = 0; k < window.count(); ++k) {
    numbers[2 * k] = static_cast<S>(window.x(k));
    numbers[2 * k + 1] = static_cast<S>(window.y(k));
  }
  return cells;
}

template <typename S>
nn::Var local_soft_argmax(nn::Tape<S>& tape, nn::Var logits, const nn::Window& window, int radius) {
  const nn::Shape shape = tape.shape(logits);
  nn::expects_shape(shape.rank() >= 1 && shape.channels() == window.count(),
                    "local_soft_argmax: as many logits as cells of the window", shape);
  const nn::Var mask = tape.make(shape);
  const int count = window.count();
  for (Index row = 0; row < shape.rows(); ++row) {
    const S* const values = tape.data(logits) + row * count;
    S* const counts = tape.data(mask) + row * count;
    const auto best = static_cast<int>(std::max_element(values, values + count) - values);
    for (int k = 0; k < count; ++k) {
      const bool near = std::abs(window.x(k) - window.x(best)) <= radius * window.step &&
                        std::abs(window.y(k) - window.y(best)) <= radius * window.step;
      counts[k] = near ? S(1) : S(0);
    }
  }
  return matmul(tape, softmax(tape, logits, mask), window_cells(tape, window));
}

template nn::Var window_cells(nn::Tape<float>&, const nn::Window&);
template nn::Var window_cells(nn::Tape<double>&, const nn::Window&);
template nn::Var local_soft_argmax(nn::Tape<float>&, nn::Var, const nn::Window&, int);
template nn::Var local_soft_argmax(nn::Tape<double>&, nn::Var, const nn::Window&, int);

}  // namespace imslam::vo

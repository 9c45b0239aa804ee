#include "vo_net/level_match.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace imslam::vo {
namespace {

using nn::Index;

/// The largest of a row of logits, the cells within `radius` of it, and their softmax.
template <typename S>
class Peak {
 public:
  Peak(const S* logits, const nn::Window& window, int radius) : logits_(logits), window_(window) {
    // The largest number is found in two steps that vectorise better than one.
    const int count = window.count();
    largest_ = Eigen::Map<const Eigen::Array<S, Eigen::Dynamic, 1>>(logits, count).maxCoeff();
    const auto at = static_cast<int>(std::find(logits, logits + count, largest_) - logits);
    const int best = at < count ? at : 0;  // none: a row with nan
    const int columns = window.columns();
    first_column_ = std::max(0, best % columns - radius);
    last_column_ = std::min(columns - 1, best % columns + radius);
    first_row_ = std::max(0, best / columns - radius);
    last_row_ = std::min(window.rows() - 1, best / columns + radius);
    for_each([&](int k, const S& exponential) {
      sum_ += exponential;
      mean_[0] += exponential * static_cast<S>(window_.x(k));
      mean_[1] += exponential * static_cast<S>(window_.y(k));
    });
    for (S& coordinate : mean_) coordinate /= sum_;
  }

  const std::array<S, 2>& mean() const { return mean_; }

  /// d[k] += p_k <dy, cell_k - mean>.
  void pull_back(const S* dy, S* d) const {
    for_each([&](int k, const S& exponential) {
      d[k] += exponential / sum_ *
              (dy[0] * (static_cast<S>(window_.x(k)) - mean_[0]) +
               dy[1] * (static_cast<S>(window_.y(k)) - mean_[1]));
    });
  }

 private:
  template <typename Body>
  void for_each(const Body& body) const {
    using std::exp;
    for (int row = first_row_; row <= last_row_; ++row) {
      for (int column = first_column_; column <= last_column_; ++column) {
        const int k = row * window_.columns() + column;
        body(k, S(exp(logits_[k] - largest_)));
      }
    }
  }

  const S* logits_;
  const nn::Window& window_;
  S largest_ = S(0);
  int first_column_ = 0;
  int last_column_ = 0;
  int first_row_ = 0;
  int last_row_ = 0;
  S sum_ = S(0);
  std::array<S, 2> mean_{};
};

}  // namespace

template <typename S>
nn::Var local_soft_argmax(nn::Tape<S>& tape, nn::Var logits, const nn::Window& window, int radius) {
  const nn::Shape shape = tape.shape(logits);
  const int count = window.count();
  nn::expects_shape(shape.rank() >= 1 && shape.channels() == count,
                    "local_soft_argmax: as many logits as cells of the window", shape);
  const nn::Var y = tape.make(shape.with_channels(2));
  for (Index row = 0; row < shape.rows(); ++row) {
    const Peak<S> peak(tape.data(logits) + row * count, window, radius);
    std::copy(peak.mean().begin(), peak.mean().end(), tape.data(y) + 2 * row);
  }
  return tape.record(y, {logits}, [=](nn::Tape<S>& t) {
    for (Index row = 0; row < shape.rows(); ++row) {
      const Peak<S> peak(t.data(logits) + row * count, window, radius);
      peak.pull_back(t.gradient_data(y) + 2 * row, t.gradient_data(logits) + row * count);
    }
  });
}

template nn::Var local_soft_argmax(nn::Tape<float>&, nn::Var, const nn::Window&, int);
template nn::Var local_soft_argmax(nn::Tape<double>&, nn::Var, const nn::Window&, int);

}  // namespace imslam::vo

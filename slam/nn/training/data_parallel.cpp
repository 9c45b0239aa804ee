#include "slam/nn/training/data_parallel.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"

namespace imslam::nn {

template <typename S>
DataParallel<S>::DataParallel(ParameterList<S> parameters, int tapes)
    : parameters_(std::move(parameters)) {
  expects(tapes >= 1, "DataParallel: at least one tape");
  for (int i = 0; i < tapes; ++i) tapes_.push_back(std::make_unique<Tape<S>>());
  losses_.resize(tapes_.size());
}

template <typename S>
double DataParallel<S>::run(std::size_t samples, const SampleLoss& loss, Gradients<S>& gradients) {
  expects(samples > 0, "DataParallel::run: at least one sample");
  for (Tensor<S>& gradient : gradients) gradient.array() = S(0);
  double sum = 0.0;
  for (std::size_t first = 0; first < samples; first += tapes_.size()) {
    const std::size_t count = std::min(tapes_.size(), samples - first);
    parallel_for(count, [&](std::size_t i) {
      Tape<S>& tape = *tapes_[i];
      tape.reset();
      const Var l = loss(tape, first + i);
      losses_[i] = static_cast<double>(tape.number(l));
      tape.backward(l);
    });
    for (std::size_t i = 0; i < count; ++i) {
      sum += losses_[i];
      tapes_[i]->add_gradients_to(parameters_, gradients);
      // A step that is not a number will be skipped: it must leave nothing behind.
      if (std::isfinite(losses_[i])) tapes_[i]->apply_observations();
    }
  }
  const double share = 1.0 / static_cast<double>(samples);
  for (Tensor<S>& gradient : gradients) gradient.array() *= S(share);
  return sum * share;
}

template class DataParallel<float>;
template class DataParallel<double>;

}  // namespace imslam::nn

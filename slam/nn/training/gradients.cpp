#include "slam/nn/training/gradients.hpp"

#include <algorithm>
#include <cmath>

namespace imslam::nn {

template <typename S>
double global_norm(const Gradients<S>& gradients) {
  double sum = 0.0;
  for (const Tensor<S>& gradient : gradients) {
    sum += gradient.array().template cast<double>().square().sum();
  }
  return std::sqrt(sum);
}

template <typename S>
double clip_global_norm(Gradients<S>& gradients, double largest) {
  expects(largest > 0.0, "clip_global_norm: the largest norm must be positive");
  const double norm = global_norm(gradients);
  if (!std::isfinite(norm) || norm <= largest) return norm;
  for (Tensor<S>& gradient : gradients) gradient.array() *= S(largest / norm);
  return norm;
}

template <typename S>
void WeightAverage<S>::update(const ParameterList<S>& parameters) {
  if (averages_.empty()) {
    for (const Parameter<S>* parameter : parameters) averages_.push_back(parameter->value.clone());
  }
  expects(averages_.size() == parameters.count(), "WeightAverage: the same parameters every time");
  const double t = static_cast<double>(updates_++);
  const double decay = std::min(decay_, (1.0 + t) / (10.0 + t));
  for (std::size_t i = 0; i < averages_.size(); ++i) {
    averages_[i].array() =
        S(decay) * averages_[i].array() + S(1.0 - decay) * parameters[i].value.array();
  }
}

template <typename S>
void WeightAverage<S>::swap(const ParameterList<S>& parameters) {
  expects(averages_.size() == parameters.count(), "WeightAverage::swap: update() comes first");
  for (std::size_t i = 0; i < averages_.size(); ++i) {
    averages_[i].array().swap(parameters[i].value.array());
  }
}

template <typename S>
void WeightAverage<S>::restore(std::int64_t updates, std::vector<Tensor<S>> averages) {
  updates_ = updates;
  averages_ = std::move(averages);
}

#define INSTANTIATE(S)                                     \
  template double global_norm(const Gradients<S>&);        \
  template double clip_global_norm(Gradients<S>&, double); \
  template class WeightAverage<S>;
INSTANTIATE(float)
INSTANTIATE(double)

}  // namespace imslam::nn

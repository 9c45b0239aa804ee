#include "slam/nn/training/gradients.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace imslam::nn {
namespace {

template <typename S>
double square_sum(const Tensor<S>& gradient) {
  return gradient.array().template cast<double>().square().sum();
}

/// What stands before the first '/'; nothing if there is none.
std::string_view network_of(std::string_view parameter) {
  const std::size_t slash = parameter.find('/');
  return slash == std::string_view::npos ? std::string_view() : parameter.substr(0, slash);
}

}  // namespace

template <typename S>
double global_norm(const Gradients<S>& gradients) {
  double sum = 0.0;
  for (const Tensor<S>& gradient : gradients) sum += square_sum(gradient);
  return std::sqrt(sum);
}

template <typename S>
double clip_network_norms(const ParameterList<S>& parameters,
                          Gradients<S>& gradients,
                          double largest) {
  expects(largest > 0.0, "clip_network_norms: the largest norm must be positive");
  expects(gradients.size() == parameters.count(), "clip_network_norms: a gradient per parameter");
  const double norm = global_norm(gradients);
  if (!std::isfinite(norm) || norm <= largest) return norm;
  for (std::size_t first = 0, end = 0; first < gradients.size(); first = end) {
    const std::string_view network = network_of(parameters[first].name);
    double sum = 0.0;
    for (; end < gradients.size() && network_of(parameters[end].name) == network; ++end) {
      sum += square_sum(gradients[end]);
    }
    const double own = std::sqrt(sum);
    if (own <= largest) continue;
    for (std::size_t i = first; i < end; ++i) gradients[i].array() *= S(largest / own);
  }
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

#define INSTANTIATE(S)                                                                \
  template double global_norm(const Gradients<S>&);                                   \
  template double clip_network_norms(const ParameterList<S>&, Gradients<S>&, double); \
  template class WeightAverage<S>;
INSTANTIATE(float)
INSTANTIATE(double)

}  // namespace imslam::nn

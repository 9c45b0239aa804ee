#include "slam/nn/training/optimizer.hpp"

#include <cmath>

namespace imslam::nn {
namespace {

template <typename S>
using Array = Eigen::Array<S, Eigen::Dynamic, 1>;

}  // namespace

template <typename S>
void Optimizer<S>::prepare(const ParameterList<S>& parameters) {
  if (memory_.empty()) memory_.resize(parameters.count());
  expects(memory_.size() == parameters.count(), "Optimizer: the same parameters in every step");
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    if (!memory_[i].empty() || !parameters[i].trainable) continue;
    for (std::size_t k = 0; k < names_.size(); ++k) {
      memory_[i].emplace_back(parameters[i].value.shape());
    }
  }
}

template <typename S>
void Optimizer<S>::step(const ParameterList<S>& parameters,
                        const Gradients<S>& gradients,
                        double rate) {
  expects(gradients.size() == parameters.count(), "Optimizer::step: one gradient per parameter");
  prepare(parameters);
  ++steps_;
  for (std::size_t i = 0; i < parameters.count(); ++i) {
    Parameter<S>& parameter = parameters[i];
    if (!parameter.trainable) continue;
    expects_shapes(gradients[i].shape() == parameter.value.shape(), "Optimizer::step: gradient",
                   gradients[i].shape(), parameter.value.shape());
    update(parameter.value.array(), gradients[i].array(), memory_[i], rate * parameter.rate_factor,
           steps_);
  }
}

template <typename S>
OptimizerState<S> Optimizer<S>::state(const ParameterList<S>& parameters) const {
  OptimizerState<S> state;
  state.steps = steps_;
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    for (std::size_t k = 0; k < memory_[i].size(); ++k) {
      state.tensors.push_back({names_[k] + "/" + parameters[i].name, memory_[i][k].clone()});
    }
  }
  return state;
}

template <typename S>
void Optimizer<S>::restore(const ParameterList<S>& parameters, const OptimizerState<S>& state) {
  memory_.clear();
  steps_ = state.steps;
  if (steps_ == 0) return;
  prepare(parameters);
  std::size_t used = 0;
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    for (std::size_t k = 0; k < memory_[i].size(); ++k) {
      const std::string name = names_[k] + "/" + parameters[i].name;
      bool found = false;
      for (const NamedTensor<S>& saved : state.tensors) {
        if (saved.name != name || saved.tensor.shape() != memory_[i][k].shape()) continue;
        memory_[i][k] = saved.tensor.clone();
        found = true;
        ++used;
      }
      if (!found) {
        throw InputError("the optimiser's state holds no '" + name + "' of the right shape",
                         ExitCode::kModel);
      }
    }
  }
  expects(used == state.tensors.size(), "Optimizer::restore: the state of another network");
}

template <typename S>
Sgd<S>::Sgd(const Options& options) : Optimizer<S>({"velocity"}), options_(options) {
  expects(options.momentum >= 0.0 && options.momentum < 1.0, "Sgd: momentum in [0, 1)");
}

template <typename S>
void Sgd<S>::update(ArrayMap<S> w,
                    ConstArrayMap<S> g,
                    std::vector<Tensor<S>>& memory,
                    double rate,
                    std::int64_t) const {
  ArrayMap<S> v = memory[0].array();
  const Array<S> pull = g + S(options_.weight_decay) * w;
  v = S(options_.momentum) * v + pull;
  if (options_.nesterov) {
    w -= S(rate) * (pull + S(options_.momentum) * v);
  } else {
    w -= S(rate) * v;
  }
}

template <typename S>
RmsProp<S>::RmsProp(const Options& options)
    : Optimizer<S>({"square", "velocity"}), options_(options) {
  expects(options.smoothing >= 0.0 && options.smoothing < 1.0, "RmsProp: smoothing in [0, 1)");
}

template <typename S>
void RmsProp<S>::update(ArrayMap<S> w,
                        ConstArrayMap<S> g,
                        std::vector<Tensor<S>>& memory,
                        double rate,
                        std::int64_t) const {
  ArrayMap<S> s = memory[0].array();
  ArrayMap<S> v = memory[1].array();
  const Array<S> pull = g + S(options_.weight_decay) * w;
  s = S(options_.smoothing) * s + S(1.0 - options_.smoothing) * pull.square();
  v = S(options_.momentum) * v + pull / (s.sqrt() + S(options_.epsilon));
  w -= S(rate) * v;
}

template <typename S>
Adam<S>::Adam(const Options& options) : Optimizer<S>({"mean", "square"}), options_(options) {
  expects(
      options.beta1 >= 0.0 && options.beta1 < 1.0 && options.beta2 >= 0.0 && options.beta2 < 1.0,
      "Adam: betas in [0, 1)");
}

template <typename S>
void Adam<S>::update(ArrayMap<S> w,
                     ConstArrayMap<S> g,
                     std::vector<Tensor<S>>& memory,
                     double rate,
                     std::int64_t step) const {
  ArrayMap<S> m = memory[0].array();
  ArrayMap<S> s = memory[1].array();
  const double coupled = options_.decoupled_decay ? 0.0 : options_.weight_decay;
  const double decoupled = options_.decoupled_decay ? options_.weight_decay : 0.0;
  const Array<S> pull = g + S(coupled) * w;
  m = S(options_.beta1) * m + S(1.0 - options_.beta1) * pull;
  s = S(options_.beta2) * s + S(1.0 - options_.beta2) * pull.square();
  const double t = static_cast<double>(step);
  const S mean_scale = S(1.0 / (1.0 - std::pow(options_.beta1, t)));
  const S square_scale = S(1.0 / (1.0 - std::pow(options_.beta2, t)));
  w -= S(rate * decoupled) * w;
  w -= S(rate) * (mean_scale * m) / ((square_scale * s).sqrt() + S(options_.epsilon));
}

#define INSTANTIATE(S)         \
  template class Optimizer<S>; \
  template class Sgd<S>;       \
  template class RmsProp<S>;   \
  template class Adam<S>;
INSTANTIATE(float)
INSTANTIATE(double)

}  // namespace imslam::nn

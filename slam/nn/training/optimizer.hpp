#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "slam/nn/parameter.hpp"

namespace imslam::nn {

/// What an optimiser remembers, for checkpoints: restore() of it goes on bit by bit.
template <typename S>
struct OptimizerState {
  std::int64_t steps = 0;
  std::vector<NamedTensor<S>> tensors;  ///< "velocity/encoder.conv1.weight", ...
};

/// Changes parameters against their gradients. w: weight, g: gradient, a: learning rate.
///
/// Parameters that are not trainable are left alone. Non-finite gradients are the caller's business
/// (clip_network_norms reports them).
template <typename S>
class Optimizer {
 public:
  virtual ~Optimizer() = default;

  void step(const ParameterList<S>& parameters, const Gradients<S>& gradients, double rate);

  OptimizerState<S> state(const ParameterList<S>& parameters) const;
  /// Throws InputError(kModel) if the state lacks one, ContractError if it has others.
  void restore(const ParameterList<S>& parameters, const OptimizerState<S>& state);

 protected:
  /// One name per array that is kept beside each weight.
  explicit Optimizer(std::vector<std::string> memory_names) : names_(std::move(memory_names)) {}

  /// `memory` holds the arrays of one weight in the order of the names, zeros at first. `step`
  /// counts from 1.
  virtual void update(ArrayMap<S> w,
                      ConstArrayMap<S> g,
                      std::vector<Tensor<S>>& memory,
                      double rate,
                      std::int64_t step) const = 0;

 private:
  void prepare(const ParameterList<S>& parameters);

  std::vector<std::string> names_;
  std::vector<std::vector<Tensor<S>>> memory_;  ///< [parameter][name]
  std::int64_t steps_ = 0;
};

/// g += decay w    v <- momentum v + g    w -= a v     (Nesterov: w -= a (g + momentum v))
template <typename S>
class Sgd : public Optimizer<S> {
 public:
  struct Options {
    double momentum = 0.0;
    bool nesterov = false;
    double weight_decay = 0.0;
  };
  Sgd() : Sgd(Options()) {}
  explicit Sgd(const Options& options);

 private:
  void update(ArrayMap<S> w,
              ConstArrayMap<S> g,
              std::vector<Tensor<S>>& memory,
              double rate,
              std::int64_t step) const override;
  Options options_;
};

/// g += decay w    s <- smoothing s + (1 - smoothing) g^2
/// v <- momentum v + g / (sqrt(s) + eps)    w -= a v
template <typename S>
class RmsProp : public Optimizer<S> {
 public:
  struct Options {
    double smoothing = 0.99;
    double momentum = 0.0;
    double epsilon = 1e-8;
    double weight_decay = 0.0;
  };
  RmsProp() : RmsProp(Options()) {}
  explicit RmsProp(const Options& options);

 private:
  void update(ArrayMap<S> w,
              ConstArrayMap<S> g,
              std::vector<Tensor<S>>& memory,
              double rate,
              std::int64_t step) const override;
  Options options_;
};

/// m <- b1 m + (1 - b1) g    s <- b2 s + (1 - b2) g^2
/// w -= a (m / (1 - b1^t)) / (sqrt(s / (1 - b2^t)) + eps)          Kingma, Ba 2015
/// Decoupled decay (AdamW): w -= a decay w before it; else g += decay w.    Loshchilov, Hutter 2019
template <typename S>
class Adam : public Optimizer<S> {
 public:
  struct Options {
    double beta1 = 0.9;
    double beta2 = 0.999;
    double epsilon = 1e-8;
    double weight_decay = 0.0;
    bool decoupled_decay = true;  ///< true: AdamW
  };
  Adam() : Adam(Options()) {}
  explicit Adam(const Options& options);

 private:
  void update(ArrayMap<S> w,
              ConstArrayMap<S> g,
              std::vector<Tensor<S>>& memory,
              double rate,
              std::int64_t step) const override;
  Options options_;
};

}  // namespace imslam::nn

#pragma once

#include <cstdint>
#include <vector>

#include "slam/nn/parameter.hpp"

namespace imslam::nn {

/// sqrt of the sum of squares of all gradients, in double.
template <typename S>
double global_norm(const Gradients<S>& gradients);

/// Scales the gradients of each network by one factor so that their norm is at most `largest`; by
/// itself, so that one with large gradients does not hold up the others of a joint list:
/// "imu_network/last.weight" is of "imu_network", names without '/' are of one network. Returns the
/// global norm before. If it is not finite the gradients are left as they are: skip the step.
template <typename S>
double clip_network_norms(const ParameterList<S>& parameters,
                          Gradients<S>& gradients,
                          double largest);

/// A slowly following copy of the weights, often better than the last ones:
///   average <- decay average + (1 - decay) value     with decay_t = min(decay, (1 + t) / (10 + t))
/// so that the first weights do not weigh on it for long.
template <typename S>
class WeightAverage {
 public:
  explicit WeightAverage(double decay) : decay_(decay) {}

  void update(const ParameterList<S>& parameters);
  /// Exchanges averages and values: once to use the averages, once more to go on training.
  void swap(const ParameterList<S>& parameters);

  std::int64_t updates() const { return updates_; }
  const std::vector<Tensor<S>>& averages() const { return averages_; }  ///< in the list's order
  void restore(std::int64_t updates, std::vector<Tensor<S>> averages);

 private:
  double decay_;
  std::int64_t updates_ = 0;
  std::vector<Tensor<S>> averages_;
};

}  // namespace imslam::nn

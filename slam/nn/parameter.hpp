#pragma once

#include <string>
#include <utility>
#include <vector>

#include "slam/nn/tensor.hpp"

namespace imslam::nn {

/// A learned value. Its gradient is not here but on each tape that used it, so that the samples of
/// a batch run side by side and are summed in a fixed order.
template <typename S>
struct Parameter {
  Parameter() = default;
  explicit Parameter(const Shape& shape, bool train = true) : value(shape), trainable(train) {}
  // A copied network is another network: tensors alone would share their numbers.
  Parameter(const Parameter& other)
      : name(other.name),
        value(other.value.clone()),
        trainable(other.trainable),
        rate_factor(other.rate_factor) {}
  Parameter(Parameter&&) = default;
  Parameter& operator=(Parameter other) {
    std::swap(name, other.name);
    std::swap(value, other.value);
    std::swap(trainable, other.trainable);
    std::swap(rate_factor, other.rate_factor);
    return *this;
  }

  std::string name;  ///< "encoder.conv1.weight": set by ParameterList::add
  Tensor<S> value;
  bool trainable = true;     ///< false: frozen, or a statistic that no gradient reaches
  double rate_factor = 1.0;  ///< learning rate beside that of the others
};

/// All parameters of a network in a fixed order, with the names that they bear in weight files.
///
/// A layer lists its own:   void collect(ParameterList<S>& list, const std::string& prefix) {
///                            list.add(prefix + "weight", weight); }
template <typename S>
class ParameterList {
 public:
  /// Names the parameter. Throws ContractError if the name is taken.
  void add(const std::string& name, Parameter<S>& parameter);

  std::size_t count() const { return parameters_.size(); }
  Parameter<S>& operator[](std::size_t i) const { return *parameters_.at(i); }
  auto begin() const { return parameters_.begin(); }
  auto end() const { return parameters_.end(); }

  Index number_count() const;  ///< numbers in all trainable parameters together

 private:
  std::vector<Parameter<S>*> parameters_;
};

/// One gradient per parameter of a list, in its order.
template <typename S>
using Gradients = std::vector<Tensor<S>>;

template <typename S>
Gradients<S> zero_gradients(const ParameterList<S>& parameters);

/// Copies values from one network to another of the same structure, name by name, e.g. from float
/// to Dual<double> for a Jacobian-vector product.
template <typename To, typename From>
void copy_values(const ParameterList<From>& from, const ParameterList<To>& to) {
  expects(from.count() == to.count(), "copy_values: two networks of the same structure");
  for (std::size_t i = 0; i < from.count(); ++i) {
    expects_shapes(from[i].value.shape() == to[i].value.shape(), "copy_values: different shapes",
                   from[i].value.shape(), to[i].value.shape());
    to[i].value = cast<To>(from[i].value);
  }
}

}  // namespace imslam::nn

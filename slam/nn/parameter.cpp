#include "slam/nn/parameter.hpp"

namespace imslam::nn {

template <typename S>
void ParameterList<S>::add(const std::string& name, Parameter<S>& parameter) {
  for (const Parameter<S>* other : parameters_) {
    if (other->name == name) throw ContractError("ParameterList: '" + name + "' is taken");
  }
  parameter.name = name;
  parameters_.push_back(&parameter);
}

template <typename S>
Index ParameterList<S>::number_count() const {
  Index sum = 0;
  for (const Parameter<S>* parameter : parameters_) {
    if (parameter->trainable) sum += parameter->value.size();
  }
  return sum;
}

template <typename S>
Gradients<S> zero_gradients(const ParameterList<S>& parameters) {
  Gradients<S> gradients;
  for (const Parameter<S>* parameter : parameters) gradients.emplace_back(parameter->value.shape());
  return gradients;
}

#define INSTANTIATE(S)             \
  template class ParameterList<S>; \
  template Gradients<S> zero_gradients(const ParameterList<S>&);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn

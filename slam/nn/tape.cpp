#include "slam/nn/tape.hpp"

#include <algorithm>

namespace imslam::nn {

template <typename S>
void Tape<S>::reset() {
  entries_.clear();
  parameters_.clear();
  observations_.clear();
  values_.rewind();
  gradients_.rewind();
}

template <typename S>
Var Tape<S>::append(const Shape& shape, S* value, bool tracked) {
  Entry entry;
  entry.shape = shape;
  entry.value = value;
  entry.tracked = tracked && training();
  entries_.push_back(entry);
  return {static_cast<int>(entries_.size()) - 1};
}

template <typename S>
Var Tape<S>::make(const Shape& shape) {
  expects(open_scratches_ == 0, "Tape::make: a Scratch is open, its end would free the value");
  return append(shape, values_.template allocate_array<S>(shape.size()), false);
}

template <typename S>
Var Tape<S>::alias(Var v, const Shape& shape) {
  expects_shapes(shape.size() == entry(v).shape.size(), "reshape: as many numbers as before",
                 entry(v).shape, shape);
  return append(shape, entry(v).value, false);
}

template <typename S>
Var Tape<S>::constant(const Shape& shape, const S* numbers) {
  const Var v = make(shape);
  std::uninitialized_copy_n(numbers, shape.size(), data(v));
  return v;
}

template <typename S>
Var Tape<S>::borrow(const Tape& owner, Var v) {
  return append(owner.entry(v).shape, owner.entry(v).value, false);
}

template <typename S>
Var Tape<S>::input(const Tensor<S>& numbers) {
  const Var v = constant(numbers);
  entry(v).tracked = training();
  return v;
}

template <typename S>
Var Tape<S>::parameter(const Parameter<S>& parameter) {
  const auto at = std::lower_bound(
      parameters_.begin(), parameters_.end(), &parameter,
      [](const KnownParameter& known, const Parameter<S>* p) { return known.parameter < p; });
  if (at != parameters_.end() && at->parameter == &parameter) return at->var;
  // Operations only read the numbers; a const pointer would need a second Entry type.
  S* const numbers = const_cast<S*>(parameter.value.data());
  const Var v = append(parameter.value.shape(), numbers, parameter.trainable);
  parameters_.insert(at, {&parameter, v});
  return v;
}

template <typename S>
Tensor<S> Tape<S>::copy(Var v) const {
  Tensor<S> numbers(entry(v).shape);
  std::copy_n(data(v), numbers.size(), numbers.data());
  return numbers;
}

template <typename S>
S Tape<S>::number(Var v) const {
  expects_shape(entry(v).shape.size() == 1, "Tape::number: a value of one number", entry(v).shape);
  return *data(v);
}

template <typename S>
S* Tape<S>::gradient_data(Var v) {
  Entry& e = entry(v);
  if (e.gradient == nullptr) {
    e.gradient = gradients_.template allocate_array<S>(e.shape.size());
    std::uninitialized_fill_n(e.gradient, e.shape.size(), S(0));
  }
  return e.gradient;
}

template <typename S>
void Tape<S>::backward(Var output, const Tensor<S>& seed) {
  expects(training(), "Tape::backward: an inference tape records nothing");
  expects_shapes(seed.shape() == shape(output), "Tape::backward: seed has the shape of output",
                 seed.shape(), shape(output));
  // Intermediate gradients of an earlier call would be sent back twice; those of leaves add up.
  for (Entry& e : entries_) {
    if (e.pull_back != nullptr) e.gradient = nullptr;
  }
  if (!wants_gradient(output)) return;
  gradient(output) += seed.array();
  for (int i = output.id; i >= 0; --i) {
    const Entry e = entries_[static_cast<std::size_t>(i)];
    if (e.pull_back != nullptr && e.gradient != nullptr) e.pull_back(e.closure, *this);
  }
}

template <typename S>
void Tape<S>::backward(Var loss) {
  expects_shape(shape(loss).size() == 1, "Tape::backward: a loss is one number", shape(loss));
  Tensor<S> one(shape(loss));
  one[0] = S(1);
  backward(loss, one);
}

template <typename S>
void Tape<S>::clear_gradients() {
  for (Entry& e : entries_) e.gradient = nullptr;
  gradients_.rewind();
}

template <typename S>
void Tape<S>::add_gradients_to(const ParameterList<S>& parameters, Gradients<S>& sums) {
  expects(sums.size() == parameters.count(), "Tape::add_gradients_to: one sum per parameter");
  for (std::size_t i = 0; i < parameters.count(); ++i) {
    const auto known =
        std::find_if(parameters_.begin(), parameters_.end(),
                     [&](const KnownParameter& k) { return k.parameter == &parameters[i]; });
    if (known == parameters_.end() || entry(known->var).gradient == nullptr) continue;
    sums[i].array() += gradient(known->var);
  }
}

template <typename S>
void Tape<S>::observe(Parameter<S>& target, Var value, double rate) {
  expects_shapes(shape(value) == target.value.shape(), "Tape::observe: same shape", shape(value),
                 target.value.shape());
  if (training()) observations_.push_back({&target, value, rate});
}

template <typename S>
void Tape<S>::apply_observations() {
  for (const Observation& seen : observations_) {
    ArrayMap<S> target = seen.target->value.array();
    target = S(1 - seen.rate) * target + S(seen.rate) * array(seen.value);
  }
  observations_.clear();
}

#define INSTANTIATE(S) template class Tape<S>;
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn

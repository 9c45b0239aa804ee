#include "slam/nn/layers/initialise.hpp"

#include <cmath>

namespace imslam::nn {

template <typename S>
void initialise_kaiming(Parameter<S>& weight, Random& random) {
  const auto fan_in = static_cast<double>(std::max<Index>(weight.value.shape().rows(), 1));
  const double deviation = std::sqrt(2.0 / fan_in);
  for (Index i = 0; i < weight.value.size(); ++i) weight.value[i] = S(deviation * random.normal());
}

template <typename S>
void initialise_xavier(Parameter<S>& weight, Random& random) {
  const Shape& shape = weight.value.shape();
  expects_shape(shape.rank() >= 2, "initialise_xavier: a weight [...,Cin,Cout]", shape);
  const auto fan_in = static_cast<double>(shape.rows());
  const auto fan_out = static_cast<double>(shape.size() / std::max<Index>(shape[-2], 1));
  initialise_uniform(weight, std::sqrt(6.0 / (fan_in + fan_out)), random);
}

template <typename S>
void initialise_uniform(Parameter<S>& weight, double bound, Random& random) {
  for (Index i = 0; i < weight.value.size(); ++i) {
    weight.value[i] = S(random.uniform(-bound, bound));
  }
}

template <typename S>
void initialise_constant(Parameter<S>& weight, double value) {
  weight.value.array() = S(value);
}

#define INSTANTIATE(S)                                              \
  template void initialise_kaiming(Parameter<S>&, Random&);         \
  template void initialise_xavier(Parameter<S>&, Random&);          \
  template void initialise_uniform(Parameter<S>&, double, Random&); \
  template void initialise_constant(Parameter<S>&, double);
IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE)

}  // namespace imslam::nn

#pragma once

#include "slam/nn/dual.hpp"

/// Every operation is a template over its scalar, defined in a .cpp file and instantiated there for
///   float         the fast path: networks run and train in it
///   double        plain loops: exact gradient checks, the slow obvious reference
///   Dual<double>  plain loops that carry a tangent: Jacobian- and Hessian-vector products
#define IMSLAM_NN_FOR_EACH_SCALAR(INSTANTIATE) \
  INSTANTIATE(float)                           \
  INSTANTIATE(double)                          \
  INSTANTIATE(Dual<double>)

namespace imslam::nn {

/// The number behind a scalar, for decisions (floor, comparisons) that have no derivative.
inline float value_of(float x) { return x; }
inline double value_of(double x) { return x; }
template <typename T>
auto value_of(const Dual<T>& x) {
  return value_of(x.value);
}

/// In which long sums are taken: float loses digits over an image.
template <typename S>
struct WideOf {
  using type = S;
};
template <>
struct WideOf<float> {
  using type = double;
};
template <typename S>
using Wide = typename WideOf<S>::type;

}  // namespace imslam::nn

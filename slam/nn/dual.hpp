#pragma once

#include <Eigen/Core>
#include <cmath>

namespace imslam::nn {

/// A value and its derivative along one direction: a + b e with e^2 = 0.
///
///   f(a + b e) = f(a) + f'(a) b e
///
/// A Tape<Dual<double>> whose inputs carry tangents gives Jacobian-vector products on the way
/// forward and, because its gradients are dual too, Hessian-vector products on the way back.
/// Comparisons look at values only. Nests (Dual<Dual<double>>).
template <typename T>
struct Dual {
  T value{};
  T tangent{};

  Dual() = default;
  Dual(double v)
      : value(T(v)), tangent(T(0.0)) {}  // NOLINT(google-explicit-constructor): a number is one
  Dual(const T& v, const T& t) : value(v), tangent(t) {}

  Dual operator-() const { return {-value, -tangent}; }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator+(const Dual& a, const Dual& b) {
    return {a.value + b.value, a.tangent + b.tangent};
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return {a.value - b.value, a.tangent - b.tangent};
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.tangent * b.value + a.value * b.tangent};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const T quotient = a.value / b.value;
    return {quotient, (a.tangent - quotient * b.tangent) / b.value};
  }
  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend bool operator!=(const Dual& a, const Dual& b) { return a.value != b.value; }
};

/// For scalar types S that may be nested in Dual: the type in which a tangent of S is kept is S.
template <typename T>
Dual<T> chain(const T& value, const T& derivative, const Dual<T>& x) {
  return {value, derivative * x.tangent};
}

template <typename T>
Dual<T> exp(const Dual<T>& x) {
  using std::exp;
  const T y = exp(x.value);
  return chain(y, y, x);
}
template <typename T>
Dual<T> log(const Dual<T>& x) {
  using std::log;
  return chain(T(log(x.value)), T(T(1.0) / x.value), x);
}
template <typename T>
Dual<T> log1p(const Dual<T>& x) {
  using std::log1p;
  return chain(T(log1p(x.value)), T(T(1.0) / (T(1.0) + x.value)), x);
}
template <typename T>
Dual<T> expm1(const Dual<T>& x) {
  using std::exp;
  using std::expm1;
  return chain(T(expm1(x.value)), T(exp(x.value)), x);
}
template <typename T>
Dual<T> sqrt(const Dual<T>& x) {
  using std::sqrt;
  const T y = sqrt(x.value);
  return chain(y, T(T(0.5) / y), x);
}
template <typename T>
Dual<T> tanh(const Dual<T>& x) {
  using std::tanh;
  const T y = tanh(x.value);
  return chain(y, T(T(1.0) - y * y), x);
}
template <typename T>
Dual<T> erf(const Dual<T>& x) {
  using std::erf;
  using std::exp;
  const T slope = T(2.0 / std::sqrt(M_PI)) * exp(-(x.value * x.value));
  return chain(T(erf(x.value)), slope, x);
}
template <typename T>
Dual<T> abs(const Dual<T>& x) {
  return x.value < T(0.0) ? -x : x;
}

}  // namespace imslam::nn

namespace Eigen {

/// Lets Dual be the scalar of Eigen's arrays and matrices.
template <typename T>
struct NumTraits<imslam::nn::Dual<T>> : GenericNumTraits<imslam::nn::Dual<T>> {
  using Real = imslam::nn::Dual<T>;
  using NonInteger = imslam::nn::Dual<T>;
  using Nested = imslam::nn::Dual<T>;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 2,
    AddCost = 2,
    MulCost = 4
  };
};

}  // namespace Eigen

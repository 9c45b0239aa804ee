#pragma once

#include "datasets/simulation/packet.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

// Arithmetic of sixteen values at once. Everything is inlined, so that it is compiled for the
// processor of the function that uses it.
namespace imslam::simulation {

[[gnu::always_inline]] inline Floats all(float value) { return Floats{} + value; }
[[gnu::always_inline]] inline Floats most(const Floats& a, const Floats& b) {
  return a > b ? a : b;
}
[[gnu::always_inline]] inline Floats least(const Floats& a, const Floats& b) {
  return a < b ? a : b;
}
[[gnu::always_inline]] inline Floats absolute(const Floats& a) { return a < 0.0F ? -a : a; }

[[gnu::always_inline]] inline Floats to_floats(const Ints& a) {
  return __builtin_convertvector(a, Floats);
}
[[gnu::always_inline]] inline Ints to_ints(const Floats& a) {
  return __builtin_convertvector(a, Ints);
}
[[gnu::always_inline]] inline Ints floor_to_ints(const Floats& a) {
  const Ints truncated = to_ints(a);
  return truncated + (a < to_floats(truncated));  // a comparison that holds is -1
}

/// log2 from the exponent bits and a parabola for the mantissa: within 0.01.
[[gnu::always_inline]] inline Floats fast_log2(const Floats& x) {
  Ints bits;
  std::memcpy(&bits, &x, sizeof bits);
  const Floats exponent = to_floats((bits >> 23) - 128);
  bits = (bits & 0x007FFFFF) | 0x3F800000;
  Floats mantissa;
  std::memcpy(&mantissa, &bits, sizeof mantissa);
  return exponent + (-0.33582878F * mantissa + 2.0F) * mantissa - 0.65871759F;
}

[[gnu::always_inline]] inline Floats dot(const Floats3& a, const Floats3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline Floats3 times(const Floats& s, const Floats3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
[[gnu::always_inline]] inline Floats3 plus(const Floats3& a, const Floats3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline Floats3 minus(const Floats3& a, const Floats3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

/// R^T a, R column major.
[[gnu::always_inline]] inline Floats3 rotated_back(const Floats (&R)[9], const Floats3& a) {
  return {R[0] * a.x + R[1] * a.y + R[2] * a.z, R[3] * a.x + R[4] * a.y + R[5] * a.z,
          R[6] * a.x + R[7] * a.y + R[8] * a.z};
}

}  // namespace imslam::simulation

#pragma GCC diagnostic pop

#include "slam/base/random.hpp"

#include <cmath>

#include "slam/base/error.hpp"

namespace imslam {
namespace {

// SplitMix64: turns related seeds into unrelated ones. Steele, Lea, Flood, OOPSLA 2014.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

constexpr std::uint64_t kExactDoubles = 1ULL << 53U;

/// The smallest 2^n - 1 that is not less than x.
std::uint64_t mask_over(std::uint64_t x) {
  for (unsigned shift = 1; shift < 64; shift *= 2) x |= x >> shift;
  return x;
}

}  // namespace

Random::Random(std::uint64_t seed) : engine_(mix(seed)), seed_(seed) {}

double Random::uniform() { return static_cast<double>(bits() >> 11U) * 0x1.0p-53; }

double Random::uniform(double low, double high) { return low + (high - low) * uniform(); }

std::int64_t Random::integer(std::int64_t low, std::int64_t high) {
  expects(low <= high, "Random::integer: low must not exceed high");
  // Unsigned: the width of the whole range does not fit into a signed number.
  const std::uint64_t width = static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low);
  std::uint64_t step = 0;
  if (width < kExactDoubles) {
    step = static_cast<std::uint64_t>(uniform() * static_cast<double>(width + 1));
  } else {
    do step = bits() & mask_over(width);
    while (step > width);
  }
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(low) + step);
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  // Marsaglia's polar method gives two at a time.
  for (;;) {
    const double u = uniform(-1.0, 1.0);
    const double v = uniform(-1.0, 1.0);
    const double s = u * u + v * v;
    if (s >= 1.0 || s == 0.0) continue;
    const double factor = std::sqrt(-2.0 * std::log(s) / s);
    spare_ = v * factor;
    has_spare_ = true;
    return u * factor;
  }
}

Eigen::Vector3d Random::normal3() {
  const double x = normal();
  const double y = normal();
  const double z = normal();
  return {x, y, z};
}

Random Random::fork(std::uint64_t stream) const { return Random(mix(seed_) ^ mix(~stream)); }

}  // namespace imslam

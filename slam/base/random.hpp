#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace imslam {

/// Seeded source of randomness, passed in wherever chance is needed.
///
/// The engine is std::mt19937_64 (bit-exact everywhere); the distributions are our own because
/// those of the standard library differ between implementations.
class Random {
 public:
  explicit Random(std::uint64_t seed);

  std::uint64_t bits() { return engine_(); }
  double uniform();                                           ///< in [0, 1)
  double uniform(double low, double high);                    ///< in [low, high)
  std::int64_t integer(std::int64_t low, std::int64_t high);  ///< in [low, high], both included
  double normal();                                            ///< mean 0, standard deviation 1
  Eigen::Vector3d normal3();
  bool chance(double probability) { return uniform() < probability; }

  /// An independent stream, e.g. one per frame, so that work can be cut up without changing it.
  /// Depends on the seed and `stream` only, not on what was drawn before.
  Random fork(std::uint64_t stream) const;

 private:
  std::mt19937_64 engine_;
  std::uint64_t seed_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace imslam

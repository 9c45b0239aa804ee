#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "imu_net/imu_buffer.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/trajectory.hpp"
#include "slam/training/truth_gravity.hpp"

namespace imslam::training {

/// Polynomials of time that are fitted to positions around each pose.
struct VelocityPolynomial {
  double half_width_s = 0.0;  ///< [s] positions this far away take part
  int degree = 0;
};

/// Slope at pose i of the least-squares polynomial through the positions around it [m/s]; fewer
/// positions than coefficients lower the degree. Empty near the ends, gaps and `jumps` (sorted; see
/// find_jumps()): there must be positions all the way on both sides.
std::optional<Eigen::Vector3d> polynomial_velocity(const Trajectory& path,
                                                   const std::vector<std::size_t>& jumps,
                                                   std::size_t i,
                                                   const VelocityPolynomial& polynomial);

/// Velocities of the truth and how they came about.
struct VelocityFit {
  bool from_file = false;                   ///< then `polynomial` means nothing
  VelocityPolynomial polynomial;            ///< that agrees with the accelerometer best
  double sigma = 0.0;                       ///< [m/s] per axis; an upper bound, see below
  std::vector<Eigen::Vector3d> velocities;  ///< v_world [m/s], one per pose
  std::vector<bool> known;                  ///< false: nothing is known there
};

/// How noisy velocities are, seen by the accelerometer: over intervals of one length, free of what
/// is constant,
///
///   e_k = v_{k+1} - v_k - g T - R_k dv_k,    6 sigma^2 = mean (e_{k+1} - e_k)^2 per axis
///
/// (three independent velocities with weights 1, -2, 1). What the IMU adds in T counts as theirs:
/// sigma is an upper bound.
class VelocityCheck {
 public:
  VelocityCheck(imu::ImuRange samples,
                const ImuNoise& noise,
                const Trajectory& truth,
                const GravityFit& gravity,
                double interval_s);

  /// `velocity(i)` of pose i. Zero if the log is too short to say.
  template <typename Velocity>
  double sigma(const Velocity& velocity) const {
    double sum = 0.0;
    std::size_t count = 0;
    for (const Triple& t : triples_) {
      const std::optional<Eigen::Vector3d> v[3] = {velocity(t.at[0]), velocity(t.at[1]),
                                                   velocity(t.at[2])};
      if (!v[0] || !v[1] || !v[2]) continue;
      sum += (*v[2] - 2.0 * *v[1] + *v[0] - t.expected).squaredNorm() / 3.0;
      ++count;
    }
    return count == 0 ? 0.0 : std::sqrt(sum / (6.0 * static_cast<double>(count)));
  }

 private:
  struct Triple {
    std::size_t at[3];
    Eigen::Vector3d expected;  ///< v2 - 2 v1 + v0 as the IMU has it
  };
  std::vector<Triple> triples_;
};

/// Chooses the polynomial that agrees with the accelerometer best, and evaluates it everywhere.
VelocityFit fit_velocities(imu::ImuRange samples,
                           const ImuNoise& noise,
                           const Trajectory& truth,
                           const std::vector<std::size_t>& jumps,
                           const GravityFit& gravity);

}  // namespace imslam::training

#include "slam/training/truth_velocity.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "imu_net/preintegration.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/time.hpp"
#include "slam/training/true_time.hpp"

namespace imslam::training {
namespace {

constexpr int kLowestDegree = 1;
constexpr int kHighestDegree = 4;
constexpr double kWidestHalf_s = 0.2;  ///< wider ones smooth the motion itself away
constexpr int kFewestHalf = 4;         ///< samples; slow truth may be wider for their sake
constexpr double kCoveredSide = 0.6;   ///< of the half width must have positions, on either side
constexpr int kHalfWidths[] = {1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 32, 40};

/// Median distance of the stamps [s].
double typical_step(const std::vector<std::int64_t>& times_ns) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < times_ns.size(); ++i) steps.push_back(times_ns[i] - times_ns[i - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return to_seconds(*middle);
}

std::vector<VelocityPolynomial> candidates(double step_s) {
  std::vector<VelocityPolynomial> result;
  for (const int half : kHalfWidths) {
    if (half > kFewestHalf && half * step_s > kWidestHalf_s) break;
    for (int degree = kLowestDegree; degree <= std::min(kHighestDegree, 2 * half); ++degree) {
      // Jitter of the stamps must not move positions in and out of the fit.
      result.push_back({(half + 0.5) * step_s, degree});
    }
  }
  return result;
}

}  // namespace

std::optional<Eigen::Vector3d> polynomial_velocity(const Trajectory& path,
                                                   const std::vector<std::size_t>& jumps,
                                                   std::size_t i,
                                                   const VelocityPolynomial& polynomial) {
  const auto& times_ns = path.times_ns;
  const std::int64_t reach_ns = to_nanoseconds(polynomial.half_width_s);
  const auto later = std::upper_bound(jumps.begin(), jumps.end(), i);
  const std::size_t begin = later == jumps.begin() ? 0 : *std::prev(later);
  const std::size_t end = later == jumps.end() ? path.size() : *later;
  std::size_t first = i;
  while (first > begin && times_ns[i] - times_ns[first - 1] <= reach_ns) --first;
  std::size_t last = i;
  while (last + 1 < end && times_ns[last + 1] - times_ns[i] <= reach_ns) ++last;
  const double least = kCoveredSide * static_cast<double>(reach_ns);
  if (static_cast<double>(times_ns[i] - times_ns[first]) < least ||
      static_cast<double>(times_ns[last] - times_ns[i]) < least) {
    return std::nullopt;
  }
  const int degree = std::min(polynomial.degree, static_cast<int>(last - first));
  // Powers above the degree are zero; their coefficients then come out as zero.
  Eigen::Matrix<double, kHighestDegree + 1, kHighestDegree + 1> H;
  H.setZero();
  H.diagonal().tail(kHighestDegree - degree).setOnes();
  Eigen::Matrix<double, kHighestDegree + 1, 3> right = decltype(right)::Zero();
  for (std::size_t k = first; k <= last; ++k) {
    const double t = to_seconds(times_ns[k] - times_ns[i]) / polynomial.half_width_s;
    Eigen::Matrix<double, kHighestDegree + 1, 1> powers = decltype(powers)::Zero();
    powers[0] = 1.0;
    for (int d = 1; d <= degree; ++d) powers[d] = powers[d - 1] * t;
    H += powers * powers.transpose();
    right += powers * (path.poses[k].translation() - path.poses[i].translation()).transpose();
  }
  const Eigen::Matrix<double, kHighestDegree + 1, 3> coefficients = H.ldlt().solve(right);
  return Eigen::Vector3d(coefficients.row(1).transpose() / polynomial.half_width_s);
}

VelocityCheck::VelocityCheck(imu::ImuRange samples,
                             const ImuNoise& noise,
                             const Trajectory& truth,
                             const GravityFit& gravity,
                             double interval_s) {
  const std::int64_t step_ns = to_nanoseconds(interval_s);
  const auto dv = [&](std::size_t from, std::size_t to) -> std::optional<Eigen::Vector3d> {
    const std::int64_t start_ns = truth.times_ns[from];
    const StampedBias* bias = bias_at(gravity.biases, start_ns);
    const ImuMotion motion = imu::preintegrate(samples, start_ns, truth.times_ns[to],
                                               bias == nullptr ? ImuBias() : bias->bias, noise);
    if (!motion.valid || motion.degraded) return std::nullopt;
    return truth.poses[from].rotation() * motion.dv + gravity.gravity_world * motion.dt_s;
  };
  for (std::size_t i = 0; i < truth.size();) {
    const auto middle = index_near(truth.times_ns, truth.times_ns[i] + step_ns, step_ns / 10);
    const auto last = index_near(truth.times_ns, truth.times_ns[i] + 2 * step_ns, step_ns / 10);
    if (!middle || !last) {
      ++i;
      continue;
    }
    const auto first_dv = dv(i, *middle);
    const auto second_dv = dv(*middle, *last);
    if (first_dv && second_dv) triples_.push_back({{i, *middle, *last}, *second_dv - *first_dv});
    i = *middle;
  }
}

VelocityFit fit_velocities(imu::ImuRange samples,
                           const ImuNoise& noise,
                           const Trajectory& truth,
                           const std::vector<std::size_t>& jumps,
                           const GravityFit& gravity) {
  VelocityFit fit;
  fit.velocities.assign(truth.size(), Eigen::Vector3d::Zero());
  fit.known.assign(truth.size(), false);
  if (truth.size() < 2) return fit;
  const auto all = candidates(typical_step(truth.times_ns));
  // Twice the widest polynomial: no two velocities of one comparison share a position.
  const VelocityCheck check(samples, noise, truth, gravity, 2.0 * all.back().half_width_s);
  std::vector<double> sigmas(all.size());
  parallel_for(all.size(), [&](std::size_t c) {
    sigmas[c] =
        check.sigma([&](std::size_t i) { return polynomial_velocity(truth, jumps, i, all[c]); });
  });
  const auto best = std::min_element(sigmas.begin(), sigmas.end()) - sigmas.begin();
  fit.polynomial = all[static_cast<std::size_t>(best)];
  fit.sigma = sigmas[static_cast<std::size_t>(best)];
  std::vector<char> known(truth.size(), 0);  // of its own byte each: written in parallel
  parallel_for(truth.size(), [&](std::size_t i) {
    const auto velocity = polynomial_velocity(truth, jumps, i, fit.polynomial);
    if (velocity) fit.velocities[i] = *velocity;
    known[i] = velocity ? 1 : 0;
  });
  fit.known.assign(known.begin(), known.end());
  return fit;
}

}  // namespace imslam::training

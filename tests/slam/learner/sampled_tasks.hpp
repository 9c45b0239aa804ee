#pragma once

#include <cmath>

#include "slam/learner/sampled_problem.hpp"

namespace imslam::learner::testing {

/// x: independent coins with P(x_i = 1) = 1 / (1 + e^-z_i); L couples them, so that no linear
/// surrogate explains it. The expectation is known by going through all x.
class CoinTask : public SampledProblem {
 public:
  static constexpr Eigen::Index kCoins = 5;
  double never_converges_above = 1e9;  ///< draws with a larger cost have no solution

  Vector draw(const Vector& z, Random& random) const override {
    Vector x(kCoins);
    const Vector p = heads(z);
    for (Eigen::Index i = 0; i < kCoins; ++i) x[i] = random.chance(p[i]) ? 1.0 : 0.0;
    return x;
  }
  std::optional<double> cost(const Vector& x) const override {
    const double L = 10.0 + 2.0 * x[0] - 3.0 * x[1] + x[2] + 1.5 * x[3] * x[4] - x[0] * x[2] +
                     0.5 * std::pow(x.sum() - 2.0, 2);
    if (L > never_converges_above) return std::nullopt;
    return L;
  }
  Vector score(const Vector& x, const Vector& z) const override { return x - heads(z); }

  static Vector heads(const Vector& z) { return (1.0 + (-z.array()).exp()).inverse(); }

  double expected_cost(const Vector& z) const {
    const Vector p = heads(z);
    double sum = 0.0;
    for (int bits = 0; bits < 1 << kCoins; ++bits) {
      Vector x(kCoins);
      double probability = 1.0;
      for (int i = 0; i < kCoins; ++i) {
        x[i] = (bits >> i) & 1;
        probability *= x[i] > 0.5 ? p[i] : 1.0 - p[i];
      }
      sum += probability * *cost(x);
    }
    return sum;
  }
};

/// s = gamma_0 + gamma^T x, the mean of which is known:  s' = dE[s]/dz = gamma_i p_i (1 - p_i).
class LinearSurrogate : public Surrogate {
 public:
  Vector gamma = Vector::Zero(CoinTask::kCoins + 1);
  double rate = 0.05;

  double value(const Vector& x, const Vector&) const override {
    return gamma[0] + gamma.tail(x.size()).dot(x);
  }
  Vector mean_slope(const Vector&, const Vector& z) const override {
    const Vector p = CoinTask::heads(z);
    return gamma.tail(z.size()).array() * p.array() * (1.0 - p.array());
  }
  void accumulate(const Vector& x, const Vector& z, double dvalue, const Vector& dslope) override {
    const Vector p = CoinTask::heads(z);
    gradient[0] += dvalue;
    gradient.tail(z.size()) += dvalue * x + Vector(dslope.array() * p.array() * (1.0 - p.array()));
  }
  void step() override {
    gamma -= rate * gradient;
    gradient.setZero();
  }
  Vector gradient = Vector::Zero(CoinTask::kCoins + 1);
};

/// x = z + sigma noise, L = sum x_i^4 / 4 + x_0 x_1; the expectation is known:
/// E[x^4] = z^4 + 6 z^2 sigma^2 + 3 sigma^4.
class GaussianTask : public SampledProblem, public ReparameterisedProblem {
 public:
  const double sigma = 0.5;

  std::optional<double> value(const Vector& x) const {
    return x.array().pow(4).sum() / 4.0 + x[0] * x[1];
  }
  Vector expected_slope(const Vector& z) const {
    Vector slope = z.array().pow(3) + 3.0 * sigma * sigma * z.array();
    slope[0] += z[1];
    slope[1] += z[0];
    return slope;
  }

  Vector draw(const Vector& z, Random& random) const override {
    return transform(z, draw_noise(random));
  }
  Vector score(const Vector& x, const Vector& z) const override {
    return (x - z) / (sigma * sigma);
  }
  std::optional<double> cost(const Vector& x) const override { return value(x); }

  Vector draw_noise(Random& random) const override {
    Vector noise(2);
    for (double& n : noise) n = random.normal();
    return noise;
  }
  Vector transform(const Vector& z, const Vector& noise) const override {
    return z + sigma * noise;
  }
  Vector pull_back(const Vector&, const Vector&, const Vector& dx) const override { return dx; }
  std::optional<CostSlope> cost_slope(const Vector& x) const override {
    Vector slope = x.array().pow(3);
    slope[0] += x[1];
    slope[1] += x[0];
    return CostSlope{*value(x), slope};
  }
};

}  // namespace imslam::learner::testing

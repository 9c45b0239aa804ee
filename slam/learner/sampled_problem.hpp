#pragma once

#include <optional>

#include "slam/base/random.hpp"
#include "slam/learner/lower_problem.hpp"

namespace imslam::learner {

// Tasks whose upper cost is an expectation over draws x that the network's z only weighs:
//
//   U(z) = E_{x ~ p(.|z)} [ L(x) ]      L(x): cost of the lower level's solution for x
//
//   log_derivative    SampledProblem
//   control_variate   SampledProblem, and a Surrogate beside it
//   reparameterised   ReparameterisedProblem
//
// Draws of one z are solved side by side: everything const here is called from several threads.

class SampledProblem : public virtual Task {
 public:
  virtual Vector draw(const Vector& z, Random& random) const = 0;    ///< x, in any encoding
  virtual std::optional<double> cost(const Vector& x) const = 0;     ///< empty: did not converge
  virtual Vector score(const Vector& x, const Vector& z) const = 0;  ///< d log p(x|z) / dz
};

/// x = T(z, noise) with noise that does not depend on z.
class ReparameterisedProblem : public virtual Task {
 public:
  struct CostSlope {
    double cost = 0.0;
    Vector by_x;
  };
  virtual Vector draw_noise(Random& random) const = 0;
  virtual Vector transform(const Vector& z, const Vector& noise) const = 0;
  virtual Vector pull_back(const Vector& z, const Vector& noise, const Vector& dx) const = 0;
  virtual std::optional<CostSlope> cost_slope(const Vector& x) const = 0;  ///< empty: unconverged
};

/// A learned stand-in s(x; gamma) for the cost whose mean over x can be differentiated.
///
/// mean_slope() must be unbiased for d/dz E[s(x)] with gamma held, whatever s has learned, e.g.
///   linear in x        s(x) = s0 + c^T x:  c^T dE[x]/dz, also with s linearised about E[x]
///   reparameterised    (dT/dz)^T ds/dx at the same draw, if x = T(z, noise)
/// A network of z alone is none: E[s score] would be 0 while ds/dz is not.
class Surrogate {
 public:
  virtual ~Surrogate() = default;
  virtual double value(const Vector& x, const Vector& z) const = 0;       ///< s(x)
  virtual Vector mean_slope(const Vector& x, const Vector& z) const = 0;  ///< s'
  /// Adds dvalue ds/dgamma + (ds'/dgamma)^T dslope to the gradient of gamma.
  virtual void accumulate(const Vector& x,
                          const Vector& z,
                          double dvalue,
                          const Vector& dslope) = 0;
  virtual void step() = 0;  ///< moves gamma against the gradient collected, which is 0 again then
};

}  // namespace imslam::learner

#pragma once

#include <ceres/loss_function.h>

#include <memory>

#include "pgo/options.hpp"

namespace imslam::pgo {

/// rho(s) of a squared norm s, and its slope, which is the weight of the edge.
struct RobustCost {
  double value;
  double slope;
};

/// The identity up to a width a, beyond it Cauchy's growth: rho(s) = a^2 (1 + ln(s / a^2)).
///
/// Of what is far out it takes as much weight as Cauchy's kernel, a^2 / s, and none of what fits.
/// Cauchy's takes some from every edge: 1 / (1 + 6 / a^2) from one that fits in six dimensions.
class CauchyTailLoss final : public ceres::LossFunction {
 public:
  explicit CauchyTailLoss(double width) : square_(width * width) {}

  void Evaluate(double s, double* rho) const override;

 private:
  double square_;
};

/// The robust kernel of visual edges; null: none.
std::unique_ptr<ceres::LossFunction> make_loss(const GraphOptions& options);

/// `loss` may be null.
RobustCost robust_cost(const ceres::LossFunction* loss, double s);

}  // namespace imslam::pgo

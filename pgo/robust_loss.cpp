#include "pgo/robust_loss.hpp"

#include <cmath>

namespace imslam::pgo {

void CauchyTailLoss::Evaluate(double s, double* rho) const {
  const bool fits = s <= square_;
  rho[0] = fits ? s : square_ * (1.0 + std::log(s / square_));
  rho[1] = fits ? 1.0 : square_ / s;
  rho[2] = fits ? 0.0 : -square_ / (s * s);
}

std::unique_ptr<ceres::LossFunction> make_loss(const GraphOptions& options) {
  if (options.kernel == "huber") {
    return std::make_unique<ceres::HuberLoss>(options.kernel_width);
  }
  if (options.kernel == "cauchy") {
    return std::make_unique<ceres::CauchyLoss>(options.kernel_width);
  }
  if (options.kernel == "cauchy_tail") {
    return std::make_unique<CauchyTailLoss>(options.kernel_width);
  }
  return nullptr;
}

RobustCost robust_cost(const ceres::LossFunction* loss, double s) {
  if (loss == nullptr) return {s, 1.0};
  double rho[3];
  loss->Evaluate(s, rho);
  return {rho[0], rho[1]};
}

}  // namespace imslam::pgo

#pragma once

#include <cmath>

namespace imslam::vo {

/// How the cost of a point grows with its squared normalised residual s.
enum class RobustKernel { kNone, kHuber, kCauchy, kGemanMcClure };

/// rho(s) and its first two derivatives with respect to s.
struct KernelValue {
  double rho = 0.0;
  double first = 1.0;
  double second = 0.0;
};

/// All kernels equal s for small s; k2 [same unit as s] is where they bend.
///
///   none           s
///   Huber          s                      for s <= k2,   2 sqrt(k2 s) - k2   beyond
///   Cauchy         k2 log(1 + s/k2)
///   Geman-McClure  s / (1 + s/k2)
inline KernelValue evaluate_kernel(RobustKernel kernel, double s, double k2) {
  switch (kernel) {
    case RobustKernel::kHuber: {
      if (s <= k2) return {s, 1.0, 0.0};
      const double slope = std::sqrt(k2 / s);
      return {2.0 * s * slope - k2, slope, -0.5 * slope / s};
    }
    case RobustKernel::kCauchy: {
      const double slope = 1.0 / (1.0 + s / k2);
      return {k2 * std::log1p(s / k2), slope, -slope * slope / k2};
    }
    case RobustKernel::kGemanMcClure: {
      const double root = 1.0 / (1.0 + s / k2);
      return {s * root, root * root, -2.0 * root * root * root / k2};
    }
    case RobustKernel::kNone:
      break;
  }
  return {s, 1.0, 0.0};
}

}  // namespace imslam::vo

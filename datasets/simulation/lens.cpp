#include "datasets/simulation/lens.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace imslam::simulation {
namespace {

constexpr int kNewtonSteps = 30;
constexpr double kConverged = 1e-13;

/// Smallest positive root s of d/dr [r (1 + k1 s + k2 s^2)] = 1 + 3 k1 s + 5 k2 s^2, s = r^2.
double fold_radius_squared(double k1, double k2) {
  const double infinity = std::numeric_limits<double>::infinity();
  const double a = 5.0 * k2;
  const double b = 3.0 * k1;
  if (std::abs(a) < 1e-12) return b < 0.0 ? -1.0 / b : infinity;
  const double discriminant = b * b - 4.0 * a;
  if (discriminant < 0.0) return infinity;
  const double root = std::sqrt(discriminant);
  double smallest = infinity;
  for (const double s : {(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)}) {
    if (s > 0.0) smallest = std::min(smallest, s);
  }
  return smallest;
}

}  // namespace

Lens::Lens(Distortion model,
           int width,
           int height,
           const Eigen::Vector4d& intrinsics,
           const std::array<double, 4>& coefficients)
    : model_(model),
      width_(width),
      height_(height),
      intrinsics_(intrinsics),
      coefficients_(coefficients),
      fold_radius_sq_(fold_radius_squared(coefficients[0], coefficients[1])) {}

Eigen::Vector2d Lens::distort_radtan(const Eigen::Vector2d& m, Eigen::Matrix2d* J_y_m) const {
  const auto& [k1, k2, p1, p2] = coefficients_;
  const double x = m.x();
  const double y = m.y();
  const double s = x * x + y * y;
  const double radial = 1.0 + s * (k1 + s * k2);
  if (J_y_m != nullptr) {
    const double slope = 2.0 * (k1 + 2.0 * s * k2);
    const double cross = slope * x * y + 2.0 * (p1 * x + p2 * y);
    *J_y_m << radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, cross,  //
        cross, radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * radial + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x),
          y * radial + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y};
}

double Lens::distorted_angle(double theta, double* derivative) const {
  const auto& [k1, k2, k3, k4] = coefficients_;
  const double s = theta * theta;
  if (derivative != nullptr) {
    *derivative = 1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * (7.0 * k3 + s * 9.0 * k4)));
  }
  return theta * (1.0 + s * (k1 + s * (k2 + s * (k3 + s * k4))));
}

std::optional<Eigen::Vector2d> Lens::project(const Eigen::Vector3d& p) const {
  Eigen::Vector2d distorted;
  if (model_ == Distortion::kRadTan) {
    if (p.z() <= 1e-6) return std::nullopt;
    const Eigen::Vector2d m(p.x() / p.z(), p.y() / p.z());
    if (m.squaredNorm() >= fold_radius_sq_) return std::nullopt;
    distorted = distort_radtan(m);
  } else {
    const double r = std::hypot(p.x(), p.y());
    const double theta = std::atan2(r, p.z());
    if (theta > 3.0) return std::nullopt;  // nearly straight behind: the angle says nothing
    const double scale = r > 1e-12 ? distorted_angle(theta) / r : 1.0 / p.z();
    distorted = scale * p.head<2>();
  }
  return Eigen::Vector2d(intrinsics_[0] * distorted.x() + intrinsics_[2],
                         intrinsics_[1] * distorted.y() + intrinsics_[3]);
}

Eigen::Vector3d Lens::undistort_radtan(const Eigen::Vector2d& distorted) const {
  Eigen::Vector2d m = distorted;
  for (int i = 0; i < kNewtonSteps; ++i) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d error = distorted - distort_radtan(m, &J);
    const Eigen::Vector2d step = J.inverse() * error;
    // Far out in strong barrel distortion a full step can jump over the fold.
    m += step * std::min(1.0, 0.3 * (1.0 + m.norm()) / (step.norm() + 1e-30));
    if (step.norm() < kConverged) break;
  }
  return Eigen::Vector3d(m.x(), m.y(), 1.0).normalized();
}

Eigen::Vector3d Lens::undistort_equidistant(const Eigen::Vector2d& distorted) const {
  const double theta_d = distorted.norm();
  if (theta_d < 1e-12) return {distorted.x(), distorted.y(), 1.0};
  double theta = theta_d;
  for (int i = 0; i < kNewtonSteps; ++i) {
    double slope = 1.0;
    const double error = theta_d - distorted_angle(theta, &slope);
    const double step = error / std::max(slope, 0.1);
    theta = std::clamp(theta + step, 0.0, 3.1);
    if (std::abs(step) < kConverged) break;
  }
  const Eigen::Vector2d across = std::sin(theta) / theta_d * distorted;
  return {across.x(), across.y(), std::cos(theta)};
}

Eigen::Vector3d Lens::direction(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - intrinsics_[2]) / intrinsics_[0],
                                  (pixel.y() - intrinsics_[3]) / intrinsics_[1]);
  return model_ == Distortion::kRadTan ? undistort_radtan(distorted)
                                       : undistort_equidistant(distorted);
}

std::string distortion_name(Distortion model) {
  return model == Distortion::kRadTan ? "radial-tangential" : "equidistant";
}

}  // namespace imslam::simulation

#pragma once

#include <Eigen/Cholesky>

#include "slam/learner/lower_problem.hpp"

namespace imslam::learner::testing {

/// The task whose answers are known:
///
///   L = 1/2 phi^T A phi - phi^T B z + 1/2 z^T C z      phi* = A^-1 B z,   A > 0
///   U = L,  or  1/2 |phi - goal|^2 + direct^T z
///
/// It offers every interface; steps are those of gradient descent.
class QuadraticTask : public LowerProblem,
                      public StationaryCost,
                      public UpperCost,
                      public FactoredCurvature,
                      public ClosedForm,
                      public SolverSteps {
 public:
  bool upper_is_lower = false;
  bool factor = true;     ///< false: hessian_solve() has no answer
  bool converges = true;  ///< false: solve() stops half-way and says it has converged
  double step_size = 0.2;

  QuadraticTask() {
    A << 4.0, 1.0, 0.5, 1.0, 3.0, -0.4, 0.5, -0.4, 2.0;
    B << 1.0, 0.3, -0.5, 0.8, 0.2, -0.7;
    C << 1.5, 0.2, 0.2, 1.1;
    goal << 0.3, -0.2, 0.5;
    direct << 0.4, -0.9;
  }

  SolveReport solve(const Vector& z) override {
    Vector phi = A.llt().solve(B * z);
    if (!converges) phi *= 0.5;
    SolveReport report = adopt(phi, z);
    report.converged = true;
    report.gradient_norm = 0.0;
    return report;
  }
  double cost() const override {
    return 0.5 * phi_.dot(A * phi_) - phi_.dot(B * z_) + 0.5 * z_.dot(C * z_);
  }
  Vector cost_by_z() const override { return C * z_ - B.transpose() * phi_; }
  Vector cost_by_phi() const override { return A * phi_ - B * z_; }
  UpperValue upper_cost() const override {
    if (upper_is_lower) return {cost(), cost_by_z(), cost_by_phi()};
    return {0.5 * (phi_ - goal).squaredNorm() + direct.dot(z_), direct, phi_ - goal};
  }
  Vector hessian_product(const Vector& v) const override { return A * v; }
  Vector mixed_product(const Vector& v) const override { return -B.transpose() * v; }
  std::optional<Vector> hessian_solve(const Vector& v) const override {
    if (!factor) return std::nullopt;
    return A.llt().solve(v);
  }
  Vector pull_back(const Vector& dphi) const override {
    return B.transpose() * A.llt().solve(dphi);
  }

  Vector first_guess() const override { return Vector::Constant(3, 0.7); }
  Vector step(const Vector& phi, const Vector& z) const override {
    return phi - step_size * (A * phi - B * z);
  }
  StepGradient pull_back(const Vector&, const Vector&, const Vector& dnext) const override {
    return {dnext - step_size * (A * dnext), step_size * (B.transpose() * dnext)};
  }
  SolveReport adopt(const Vector& phi, const Vector& z) override {
    phi_ = phi;
    z_ = z;
    SolveReport report;
    report.gradient_norm = cost_by_phi().lpNorm<Eigen::Infinity>();
    report.converged = report.gradient_norm < 1e-9;
    return report;
  }

  Eigen::Matrix3d A;
  Eigen::Matrix<double, 3, 2> B;
  Eigen::Matrix2d C;
  Eigen::Vector3d goal;
  Eigen::Vector2d direct;

 private:
  Vector phi_;
  Vector z_;
};

}  // namespace imslam::learner::testing

#pragma once

#include <Eigen/LU>

#include "slam/learner/lower_problem.hpp"

namespace imslam::learner::testing {

/// min 1/2 |phi - M z|^2   s.t.   1/2 phi^T D phi - 1 - 1/2 z_0^2 = 0  (an ellipsoid that z blows)
///                                 phi_2 - z_1 <= 0
/// U = 1/2 |phi - goal|^2 + direct^T z. Solved by Newton's method on the KKT conditions, without
/// the inequality first. The ellipsoid bends, so the Lagrangian's Hessian is not that of L.
class ConstrainedTask : public LowerProblem,
                        public UpperCost,
                        public Curvature,
                        public FactoredConstraints {
 public:
  bool twice = false;       ///< states the equality twice: the KKT system is singular
  bool factor = false;      ///< answers kkt_solve()
  bool wrong_sign = false;  ///< claims that the inequality pulls

  SolveReport solve(const Vector& z) override {
    z_ = z;
    held_ = false;
    SolveReport report = newton();
    if (phi_[2] > z_[1]) {
      held_ = true;
      report = newton();
    }
    return report;
  }
  UpperValue upper_cost() const override {
    return {0.5 * (phi_ - goal).squaredNorm() + direct.dot(z_), direct, phi_ - goal};
  }
  Vector hessian_product(const Vector& v) const override { return v + lambda_[0] * (D * v); }
  Vector mixed_product(const Vector& v) const override { return -M.transpose() * v; }
  ConstraintValues constraints() const override {
    const Eigen::Index rows = twice ? 3 : 2;
    ConstraintValues all{
        Vector(rows), lambda_, {1, 0}, Matrix::Zero(rows, 3), Matrix::Zero(rows, 2)};
    all.values.head<2>() = values();
    all.by_phi.topRows<2>() = slopes();
    all.by_z.topRows<2>() << -z_[0], 0.0, 0.0, -1.0;
    if (wrong_sign) all.multipliers[1] = -0.1;
    if (!twice) return all;
    all.multipliers.conservativeResize(3);
    all.multipliers[2] = 0.0;
    all.is_equality.push_back(1);
    all.values[2] = all.values[0];
    all.by_phi.row(2) = all.by_phi.row(0);
    all.by_z.row(2) = all.by_z.row(0);
    return all;
  }
  std::optional<Solution> kkt_solve(const Vector& dphi,
                                    const std::vector<Eigen::Index>& active) const override {
    if (!factor) return std::nullopt;
    const Matrix A = slopes().topRows(static_cast<Eigen::Index>(active.size()));  // 0, or 0 and 1
    const Matrix H = Matrix::Identity(3, 3) + lambda_[0] * Matrix(D);
    const Matrix H_inverse = H.inverse();
    const Vector w = (A * H_inverse * A.transpose()).inverse() * (A * H_inverse * dphi);
    return Solution{H_inverse * (dphi - A.transpose() * w), w};
  }
  bool held() const { return held_; }

  const Eigen::Matrix3d D = Eigen::Vector3d(2.0, 1.0, 1.5).asDiagonal();
  const Eigen::Matrix<double, 3, 2> M =
      (Eigen::Matrix<double, 3, 2>() << 1.0, 0.4, -0.6, 1.1, 0.9, 0.7).finished();
  const Eigen::Vector3d goal{0.4, 0.1, -0.3};
  const Eigen::Vector2d direct{0.2, -0.5};

 private:
  Eigen::Vector2d values() const {
    return {0.5 * phi_.dot(D * phi_) - 1.0 - 0.5 * z_[0] * z_[0], phi_[2] - z_[1]};
  }
  Eigen::Matrix<double, 2, 3> slopes() const {
    Eigen::Matrix<double, 2, 3> A;
    A << (D * phi_).transpose(), 0.0, 0.0, 1.0;
    return A;
  }
  SolveReport newton() {
    const Eigen::Index m = held_ ? 2 : 1;
    phi_ = M * z_;
    lambda_ = Eigen::Vector2d::Zero();
    SolveReport report;
    for (report.iterations = 0; report.iterations < 50; ++report.iterations) {
      const Matrix A = slopes().topRows(m);
      Vector F(3 + m);
      F << phi_ - M * z_ + A.transpose() * lambda_.head(m), values().head(m);
      report.gradient_norm = F.lpNorm<Eigen::Infinity>();
      report.converged = report.gradient_norm < 1e-12;
      if (report.converged) break;
      Matrix K = Matrix::Zero(3 + m, 3 + m);
      K.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() + lambda_[0] * D;
      K.topRightCorner(3, m) = A.transpose();
      K.bottomLeftCorner(m, 3) = A;
      const Vector step = K.partialPivLu().solve(F);
      phi_ -= step.head<3>();
      lambda_.head(m) -= step.tail(m);
    }
    return report;
  }

  Eigen::Vector3d phi_;
  Vector lambda_;
  Vector z_;
  bool held_ = false;
};

}  // namespace imslam::learner::testing

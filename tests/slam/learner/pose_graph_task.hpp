#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/learner/lower_problem.hpp"
#include "slam/lie/se3.hpp"

namespace imslam::learner::testing {

/// Nonlinear least squares on SE(3): a chain of poses with loop edges, the first pose held.
///
///   L = 1/2 sum_e |w_e r_e|^2      r = Log(Z^-1 X_i^-1 X_j)      Z = Exp(z_e): the network's word
///   U = 1/2 sum_e |u_e r_e|^2      U = L if u = w
///
/// States are 7 numbers a pose, tangents [rho theta] on the right. Second derivatives are central
/// differences of the first along one direction. Solved by Gauss-Newton; the steps that can be
/// unrolled are those of Newton's method with the Hessian held at the first guess.
class PoseGraphTask : public LowerProblem,
                      public StationaryCost,
                      public UpperCost,
                      public Curvature,
                      public SolverSteps {
 public:
  /// Measurements that contradict each other by `noise` ([m], [rad]).
  PoseGraphTask(int poses, double noise) : count_(poses) {
    Random random(5);
    truth_.emplace_back();
    for (int i = 0; i < poses; ++i) truth_.push_back(truth_.back() * lie::SE3d::exp(motion(i)));
    for (int i = 0; i < poses; ++i) add_edge(i, i + 1, random, noise);
    for (int i = 0; i + 3 <= poses; i += 2) add_edge(i, i + 3, random, noise);
    phi_ = first_guess();
    z_ = measured;
    Matrix H = Matrix::Zero(6 * count_, 6 * count_);
    Vector g = Vector::Zero(6 * count_);
    normal_equations(poses_of(phi_), z_, H, g);
    held_.compute(H);
  }

  Vector measured;                    ///< z, 6 an edge
  std::vector<double> lower_weights;  ///< w
  std::vector<double> upper_weights;  ///< u

  SolveReport solve(const Vector& z) override {
    Vector phi = first_guess();
    for (int i = 0; i < 100; ++i) {
      Matrix H = Matrix::Zero(6 * count_, 6 * count_);
      Vector g = Vector::Zero(6 * count_);
      normal_equations(poses_of(phi), z, H, g);
      if (g.lpNorm<Eigen::Infinity>() < 1e-13) break;
      phi = moved(phi, -H.llt().solve(g));
    }
    return adopt(phi, z);
  }
  double cost() const override { return slopes(phi_, z_, lower_weights).cost; }
  Vector cost_by_z() const override { return slopes(phi_, z_, lower_weights).by_z; }
  Vector cost_by_phi() const override { return slopes(phi_, z_, lower_weights).by_phi; }
  UpperValue upper_cost() const override { return slopes(phi_, z_, upper_weights); }
  Vector hessian_product(const Vector& v) const override { return along(phi_, z_, v).by_phi; }
  Vector mixed_product(const Vector& v) const override { return along(phi_, z_, v).by_z; }
  /// J^T W J v, what a solver would have factored.
  Vector gauss_newton_product(const Vector& v) const {
    Matrix H = Matrix::Zero(6 * count_, 6 * count_);
    Vector g = Vector::Zero(6 * count_);
    normal_equations(poses_of(phi_), z_, H, g);
    return H * v;
  }

  Vector first_guess() const override {
    Vector phi(7 * count_);
    for (Eigen::Index i = 0; i < count_; ++i) {
      store(truth_[static_cast<std::size_t>(i) + 1] * lie::SE3d::exp(0.3 * motion(2 - i)), i, phi);
    }
    return phi;
  }
  Vector step(const Vector& phi, const Vector& z) const override {
    return moved(phi, -held_.solve(slopes(phi, z, lower_weights).by_phi));
  }
  /// phi Exp(e) -> next Exp(Ad(Exp(-d)) e - J_r(d) P G e) with d = -P g, G = dg/dphi; off the
  /// solution G^T b = G b - ad(b)^T g, because left-invariant fields do not commute.
  StepGradient pull_back(const Vector& phi, const Vector& z, const Vector& dnext) const override {
    const Vector g = slopes(phi, z, lower_weights).by_phi;
    const Vector d = -held_.solve(g);
    Vector back(dnext.size());
    Vector straight(dnext.size());
    for (Eigen::Index i = 0; i < count_; ++i) {
      const Vector6 di = d.segment<6>(6 * i);
      const Vector6 ai = dnext.segment<6>(6 * i);
      back.segment<6>(6 * i) = lie::SE3d::right_jacobian(di).transpose() * ai;
      straight.segment<6>(6 * i) = lie::SE3d::exp(-di).adjoint().transpose() * ai;
    }
    const Vector b = held_.solve(back);
    const UpperValue curved = along(phi, z, b);
    StepGradient result{straight - curved.by_phi, -curved.by_z};
    for (Eigen::Index i = 0; i < count_; ++i) {
      result.by_phi.segment<6>(6 * i) +=
          bracket(b.segment<6>(6 * i)).transpose() * g.segment<6>(6 * i);
    }
    return result;
  }
  SolveReport adopt(const Vector& phi, const Vector& z) override {
    phi_ = phi;
    z_ = z;
    SolveReport report;
    report.gradient_norm = cost_by_phi().lpNorm<Eigen::Infinity>();
    report.converged = report.gradient_norm < 1e-9;
    return report;
  }
  Eigen::Index unknowns() const { return 6 * count_; }

 private:
  using Vector6 = lie::SE3d::Tangent;
  using Matrix6 = lie::SE3d::Matrix6;
  struct Edge {
    int from;
    int to;
  };

  static Vector6 motion(Eigen::Index i) {
    const double s = static_cast<double>(i);
    return (Vector6() << 0.9, 0.1 * s, -0.2, 0.05 * s, 0.2, 0.3 - 0.02 * s).finished() * 0.5;
  }
  void add_edge(int from, int to, Random& random, double noise) {
    const auto& X = truth_;
    const lie::SE3d T =
        X[static_cast<std::size_t>(from)].inverse() * X[static_cast<std::size_t>(to)];
    Vector6 error;
    for (double& e : error) e = noise * random.normal();
    edges_.push_back({from, to});
    measured.conservativeResize(measured.size() + 6);
    measured.tail<6>() = (T * lie::SE3d::exp(error)).log();
    const bool loop = to != from + 1;
    lower_weights.push_back(loop ? 0.7 : 1.3);
    upper_weights.push_back(loop ? 0.0 : 1.0);  // as published: other weights, chain only
  }

  static void store(const lie::SE3d& X, Eigen::Index i, Vector& phi) {
    phi.segment<3>(7 * i) = X.translation();
    phi.segment<4>(7 * i + 3) = X.rotation().quaternion().coeffs();
  }
  std::vector<lie::SE3d> poses_of(const Vector& phi) const {
    std::vector<lie::SE3d> poses(1);
    for (Eigen::Index i = 0; i < count_; ++i) {
      const Eigen::Quaterniond q(Eigen::Vector4d(phi.segment<4>(7 * i + 3)));
      poses.emplace_back(lie::SO3d(q), phi.segment<3>(7 * i));
    }
    return poses;
  }
  Vector moved(const Vector& phi, const Vector& tangent) const {
    const std::vector<lie::SE3d> poses = poses_of(phi);
    Vector next(phi.size());
    for (Eigen::Index i = 0; i < count_; ++i) {
      store(poses[static_cast<std::size_t>(i) + 1] * lie::SE3d::exp(tangent.segment<6>(6 * i)), i,
            next);
    }
    return next;
  }
  static Matrix6 bracket(const Vector6& tau) {  // ad(tau) x = [tau, x]
    Matrix6 ad = Matrix6::Zero();
    ad.topLeftCorner<3, 3>() = lie::skew(tau.tail<3>());
    ad.bottomRightCorner<3, 3>() = ad.topLeftCorner<3, 3>();
    ad.topRightCorner<3, 3>() = lie::skew(tau.head<3>());
    return ad;
  }

  /// Residual of one edge and its slope with respect to E Exp(tau), E = Z^-1 X_i^-1 X_j.
  struct EdgeSlope {
    Vector6 r;
    Matrix6 J_r_E;
    Matrix6 J_E_from;
    Matrix6 J_E_z;
  };
  EdgeSlope edge_slope(const std::vector<lie::SE3d>& X, const Vector& z, std::size_t e) const {
    const Vector6 ze = z.segment<6>(6 * static_cast<Eigen::Index>(e));
    const lie::SE3d& from = X[static_cast<std::size_t>(edges_[e].from)];
    const lie::SE3d& to = X[static_cast<std::size_t>(edges_[e].to)];
    const lie::SE3d E = lie::SE3d::exp(-ze) * from.inverse() * to;
    EdgeSlope slope;
    slope.r = E.log();
    slope.J_r_E = lie::SE3d::right_jacobian_inverse(slope.r);
    slope.J_E_from = -(to.inverse() * from).adjoint();
    slope.J_E_z = -E.inverse().adjoint() * lie::SE3d::right_jacobian(ze);
    return slope;
  }

  UpperValue slopes(const Vector& phi, const Vector& z, const std::vector<double>& weights) const {
    const std::vector<lie::SE3d> X = poses_of(phi);
    UpperValue value{0.0, Vector::Zero(z.size()), Vector::Zero(6 * count_)};
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const EdgeSlope slope = edge_slope(X, z, e);
      const double weight = weights[e] * weights[e];
      value.cost += 0.5 * weight * slope.r.squaredNorm();
      const Vector6 dE = weight * slope.J_r_E.transpose() * slope.r;
      value.by_z.segment<6>(6 * static_cast<Eigen::Index>(e)) = slope.J_E_z.transpose() * dE;
      add(edges_[e].to, dE, value.by_phi);
      add(edges_[e].from, slope.J_E_from.transpose() * dE, value.by_phi);
    }
    return value;
  }
  static void add(int pose, const Vector6& slope, Vector& sum) {
    if (pose > 0) sum.segment<6>(6 * (pose - 1)) += slope;
  }

  void normal_equations(const std::vector<lie::SE3d>& X,
                        const Vector& z,
                        Matrix& H,
                        Vector& g) const {
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const EdgeSlope slope = edge_slope(X, z, e);
      Matrix J = Matrix::Zero(6, 6 * count_);
      const auto put = [&](int pose, const Matrix6& block) {
        if (pose > 0) J.middleCols<6>(6 * (pose - 1)) = block;
      };
      put(edges_[e].to, lower_weights[e] * slope.J_r_E);
      put(edges_[e].from, lower_weights[e] * slope.J_r_E * slope.J_E_from);
      H += J.transpose() * J;
      g += J.transpose() * (lower_weights[e] * slope.r);
    }
  }

  /// d/dh of the slopes of L at phi Exp(h v).
  UpperValue along(const Vector& phi, const Vector& z, const Vector& v) const {
    const double norm = v.norm();
    if (norm == 0.0) return {0.0, Vector::Zero(z.size()), Vector::Zero(v.size())};
    constexpr double kStep = 1e-5;
    const Vector h = v * (kStep / norm);
    const UpperValue ahead = slopes(moved(phi, h), z, lower_weights);
    const UpperValue behind = slopes(moved(phi, -h), z, lower_weights);
    const double scale = norm / (2.0 * kStep);
    return {0.0, scale * (ahead.by_z - behind.by_z), scale * (ahead.by_phi - behind.by_phi)};
  }

  Eigen::Index count_;  ///< poses that move
  std::vector<lie::SE3d> truth_;
  std::vector<Edge> edges_;
  Eigen::LLT<Matrix> held_;  ///< Hessian of Gauss-Newton at the first guess
  Vector phi_;
  Vector z_;
};

}  // namespace imslam::learner::testing

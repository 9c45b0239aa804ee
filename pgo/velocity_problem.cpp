#include "pgo/velocity_problem.hpp"

#include <Eigen/SparseCholesky>
#include <cmath>

#include "slam/base/time.hpp"

namespace imslam::pgo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using lie::SO3d;

constexpr int kRounds = 3;
constexpr double kHuberWidth = 3.0;          // standard deviations
constexpr double kUnseenVelocityStep = 1.0;  // [m/s] where nothing was measured

}  // namespace

/// Adds three rows  sum_k C_k x_k = b  with standard deviation sigma.
class VelocityProblem::Rows {
 public:
  explicit Rows(Eigen::Index columns) : H(columns, columns), g(VectorXd::Zero(columns)) {}
  struct Term {
    Eigen::Index column;
    Matrix3d C;
  };
  void add(const std::vector<Term>& terms,
           const Vector3d& b,
           double sigma,
           bool robust,
           const VectorXd* at) {
    double weight = 1.0 / (sigma * sigma);
    if (robust && at != nullptr) {
      Vector3d r = -b;
      for (const Term& term : terms) r += term.C * at->segment<3>(term.column);
      const double size = r.norm() / sigma;
      if (size > kHuberWidth) weight *= kHuberWidth / size;
    }
    for (const Term& a : terms) {
      g.segment<3>(a.column) += weight * a.C.transpose() * b;
      for (const Term& c : terms) {
        const Matrix3d block = weight * a.C.transpose() * c.C;
        for (int row = 0; row < 3; ++row) {
          for (int column = 0; column < 3; ++column) {
            triplets.emplace_back(static_cast<int>(a.column) + row,
                                  static_cast<int>(c.column) + column, block(row, column));
          }
        }
      }
    }
  }
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::SparseMatrix<double> H;
  VectorXd g;
};

VelocityProblem::VelocityProblem(const std::vector<RelativeMotion>& visual,
                                 const std::vector<ImuMotion>& inertial,
                                 const Vector3d& gyro_bias,
                                 const InitializationOptions& options)
    : visual_(visual), inertial_(inertial), gyro_bias_(gyro_bias), options_(options) {
  chain_rotations();
}

bool VelocityProblem::solve(const Vector3d& g0,
                            const Matrix3d& G,
                            bool hold_third,
                            Solution& solution) const {
  VectorXd x;
  for (int round = 0; round < kRounds; ++round) {
    if (!solve_once(g0, G, hold_third, round == 0 ? nullptr : &x, x, solution)) return false;
  }
  return true;
}

void VelocityProblem::chain_rotations() {
  R_body0_body_.push_back(SO3d());
  for (std::size_t i = 0; i < visual_.size(); ++i) {
    SO3d step;
    if (inertial_[i].valid) {
      step = inertial_[i].dR * SO3d::exp(inertial_[i].J_dR_bias.leftCols<3>() *
                                         (gyro_bias_ - inertial_[i].bias.gyro));
    } else if (visual_[i].valid) {
      step = visual_[i].T_body0_body1.rotation();
    }
    R_body0_body_.push_back(R_body0_body_.back() * step);
  }
}

void VelocityProblem::add_interval(
    std::size_t i, const Vector3d& g0, const Matrix3d& G, const VectorXd* at, Rows& rows) const {
  const RelativeMotion& visual = visual_[i];
  const ImuMotion& inertial = inertial_[i];
  const Matrix3d I = Matrix3d::Identity();
  const Matrix3d R = R_body0_body_[i].matrix();
  const auto v0 = static_cast<Eigen::Index>(6 + 3 * i);
  const Vector3d t = R * visual.T_body0_body1.translation();
  const double sigma_t =
      std::sqrt(visual.covariance.topLeftCorner<3, 3>().trace() / 3.0 +
                options_.visual_translation_floor * options_.visual_translation_floor);
  if (inertial.valid) {
    const double dt = inertial.dt_s;
    const Vector3d db = gyro_bias_ - inertial.bias.gyro;
    const Vector3d dv = R * (inertial.dv + inertial.J_dv_bias.leftCols<3>() * db);
    const Vector3d dp = R * (inertial.dp + inertial.J_dp_bias.leftCols<3>() * db);
    const double sigma_v = std::sqrt(inertial.covariance.block<3, 3>(3, 3).trace() / 3.0);
    const double sigma_p = std::sqrt(inertial.covariance.block<3, 3>(6, 6).trace() / 3.0);
    rows.add({{v0 + 3, I}, {v0, -I}, {0, -dt * G}, {3, -R * inertial.J_dv_bias.rightCols<3>()}},
             dv + dt * g0, sigma_v, false, at);
    if (visual.valid) {
      rows.add({{v0, dt * I}, {0, 0.5 * dt * dt * G}, {3, R * inertial.J_dp_bias.rightCols<3>()}},
               t - dp - 0.5 * dt * dt * g0, std::hypot(sigma_t, sigma_p), true, at);
    }
    return;
  }
  const double dt = to_seconds(visual.time1_ns - visual.time0_ns);
  rows.add({{v0 + 3, I}, {v0, -I}}, Vector3d::Zero(), kUnseenVelocityStep, false, at);
  if (visual.valid && dt > 0.0) {
    rows.add({{v0, 0.5 * dt * I}, {v0 + 3, 0.5 * dt * I}}, t, sigma_t + 0.1 * dt, true, at);
  }
}

bool VelocityProblem::solve_once(const Vector3d& g0,
                                 const Matrix3d& G,
                                 bool hold_third,
                                 const VectorXd* at,
                                 VectorXd& x,
                                 Solution& solution) const {
  const auto count = static_cast<Eigen::Index>(R_body0_body_.size());
  Rows rows(6 + 3 * count);
  for (std::size_t i = 0; i < visual_.size(); ++i) add_interval(i, g0, G, at, rows);
  // The unknown is the change from the bias that the motions were integrated with.
  rows.add({{3, Matrix3d::Identity()}}, Vector3d::Zero(), options_.accel_bias_sigma, false, at);
  // Weak enough not to matter, and enough to keep the factorisation of a hopeless case finite.
  for (Eigen::Index c = 0; c < 6 + 3 * count; ++c) {
    const double hold = c == 2 && hold_third ? 1e12 : 1e-8;
    rows.triplets.emplace_back(static_cast<int>(c), static_cast<int>(c), hold);
  }
  rows.H.setFromTriplets(rows.triplets.begin(), rows.triplets.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(rows.H);
  if (ldlt.info() != Eigen::Success) return false;
  x = ldlt.solve(rows.g);
  if (!x.allFinite()) return false;

  solution.gravity = g0 + G * x.head<3>();
  solution.accel_bias = integrated_accel_bias() + x.segment<3>(3);
  solution.velocities.clear();
  for (Eigen::Index i = 0; i < count; ++i) {
    solution.velocities.emplace_back(x.segment<3>(6 + 3 * i));
  }
  for (int c = 0; c < 3; ++c) {
    const VectorXd column = ldlt.solve(VectorXd::Unit(x.size(), c));
    solution.parameter_covariance.col(c) = column.head<3>();
  }
  return true;
}

Vector3d VelocityProblem::integrated_accel_bias() const {
  for (const ImuMotion& motion : inertial_) {
    if (motion.valid) return motion.bias.accel;
  }
  return Vector3d::Zero();
}

}  // namespace imslam::pgo

#include "pgo/initialization.hpp"

#include <Eigen/SparseCholesky>
#include <cmath>

#include "pgo/gyro_bias.hpp"
#include "pgo/prediction.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::pgo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using lie::SO3d;

constexpr int kSphereRounds = 4;
constexpr double kHuberWidth = 3.0;          // standard deviations
constexpr double kUnseenVelocityStep = 1.0;  // [m/s] where nothing was measured

/// Linear least squares in [gravity parameters (3), accel bias (3), v_0, v_1, ...], body 0's frame.
/// The gravity vector is g = g0 + G u: G = I to find it, or the tangent plane of the sphere (then
/// the third parameter is held at zero).
class VelocityProblem {
 public:
  VelocityProblem(const std::vector<RelativeMotion>& visual,
                  const std::vector<ImuMotion>& inertial,
                  const Vector3d& gyro_bias,
                  const InitializationOptions& options)
      : visual_(visual), inertial_(inertial), gyro_bias_(gyro_bias), options_(options) {
    chain_rotations();
  }

  struct Solution {
    Vector3d gravity;
    Vector3d accel_bias;
    std::vector<Vector3d> velocities;
    Matrix3d parameter_covariance;  ///< of u
  };

  /// Twice: all weights one, then Huber weights at the first solution.
  bool solve(const Vector3d& g0, const Matrix3d& G, bool hold_third, Solution& solution) const {
    VectorXd x;
    for (int round = 0; round < 3; ++round) {
      if (!solve_once(g0, G, hold_third, round == 0 ? nullptr : &x, x, solution)) return false;
    }
    return true;
  }

  const std::vector<SO3d>& rotations() const { return R_body0_body_; }

 private:
  void chain_rotations() {
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

  /// Adds three rows  sum_k C_k x_k = b  with standard deviation sigma.
  class Rows {
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

  void add_interval(
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

  bool solve_once(const Vector3d& g0,
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

  Vector3d integrated_accel_bias() const {
    for (const ImuMotion& motion : inertial_) {
      if (motion.valid) return motion.bias.accel;
    }
    return Vector3d::Zero();
  }

  const std::vector<RelativeMotion>& visual_;
  const std::vector<ImuMotion>& inertial_;
  Vector3d gyro_bias_;
  InitializationOptions options_;
  std::vector<SO3d> R_body0_body_;
};

/// Two columns that span the plane orthogonal to n, scaled by `size`; the third column is zero.
Matrix3d tangent_plane(const Vector3d& n, double size) {
  const Vector3d other = std::abs(n.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY();
  Matrix3d B = Matrix3d::Zero();
  B.col(0) = n.cross(other).normalized();
  B.col(1) = n.cross(B.col(0));
  return size * B;
}

std::vector<State> world_states(const VelocityProblem& problem,
                                const VelocityProblem::Solution& solution,
                                const std::vector<RelativeMotion>& visual,
                                const std::vector<ImuMotion>& inertial,
                                const ImuBias& bias) {
  const SO3d R_world_body0 = level(solution.gravity);
  std::vector<State> states;
  Vector3d p = Vector3d::Zero();  // in body 0's frame
  for (std::size_t i = 0; i < solution.velocities.size(); ++i) {
    const SO3d& R = problem.rotations()[i];
    State state;
    const bool last = i == visual.size();
    state.time_ns = last ? visual.back().time1_ns : visual[i].time0_ns;
    state.nav.T_world_body = lie::SE3d(R_world_body0 * R, R_world_body0 * p);
    state.nav.v_world = R_world_body0 * solution.velocities[i];
    state.bias = bias;
    states.push_back(state);
    if (last) break;
    const double dt = to_seconds(visual[i].time1_ns - visual[i].time0_ns);
    p += visual[i].valid     ? Vector3d(R * visual[i].T_body0_body1.translation())
         : inertial[i].valid ? Vector3d(solution.velocities[i] * dt +
                                        0.5 * dt * dt * solution.gravity + R * inertial[i].dp)
                             : Vector3d(solution.velocities[i] * dt);
  }
  return states;
}

std::string insufficient_data(const std::vector<RelativeMotion>& visual,
                              const std::vector<ImuMotion>& inertial,
                              const InitializationOptions& options) {
  int both = 0;
  double duration_s = 0.0;
  for (std::size_t i = 0; i < visual.size(); ++i) {
    if (!visual[i].valid || !inertial[i].valid) continue;
    ++both;
    duration_s += inertial[i].dt_s;
  }
  if (both < options.min_intervals || duration_s < options.min_duration_s) {
    return "only " + std::to_string(both) + " intervals (" + std::to_string(duration_s) +
           " s) have both vision and IMU data";
  }
  return "";
}

}  // namespace

void InitializationOptions::validate() const {
  expects(gravity_magnitude > 0.0 && gravity_tolerance > 0.0 && accel_bias_sigma > 0.0 &&
              max_gravity_sigma_rad > 0.0 && min_intervals >= 2,
          "initialisation: options must be positive, min_intervals at least 2");
}

SO3d level(const Vector3d& gravity_body0) {
  const Vector3d up = -gravity_body0.normalized();
  const bool x_is_steep = std::abs(up.x()) > std::cos(M_PI / 6.0);
  const Vector3d ahead = x_is_steep ? Vector3d::UnitZ() : Vector3d::UnitX();
  Matrix3d R_body0_world;
  R_body0_world.col(2) = up;
  R_body0_world.col(0) = (ahead - up * up.dot(ahead)).normalized();
  R_body0_world.col(1) = up.cross(R_body0_world.col(0));
  return SO3d::from_matrix(R_body0_world).inverse();
}

Initialization initialize(const std::vector<RelativeMotion>& visual,
                          const std::vector<ImuMotion>& inertial,
                          const InitializationOptions& options) {
  options.validate();
  expects(visual.size() == inertial.size(), "initialisation: one motion of each kind per interval");
  Initialization result;
  result.reason = insufficient_data(visual, inertial, options);
  if (!result.reason.empty()) return result;

  result.bias.gyro = fit_gyro_bias(visual, inertial, options.visual_rotation_floor);
  const VelocityProblem problem(visual, inertial, result.bias.gyro, options);
  VelocityProblem::Solution solution;
  if (!problem.solve(Vector3d::Zero(), Matrix3d::Identity(), false, solution)) {
    result.reason = "velocities and gravity are not determined by the data";
    return result;
  }
  const double measured = solution.gravity.norm();
  if (!(std::abs(measured - options.gravity_magnitude) <
        options.gravity_tolerance * options.gravity_magnitude)) {
    result.reason = "measured gravity is " + std::to_string(measured) +
                    " m/s^2; check units and extrinsics of the IMU";
    return result;
  }
  for (int round = 0; round < kSphereRounds; ++round) {
    const Vector3d n = solution.gravity.normalized();
    const double G = options.gravity_magnitude;
    if (!problem.solve(G * n, tangent_plane(n, G), true, solution)) {
      result.reason = "the direction of gravity is not determined by the data";
      return result;
    }
  }
  result.gravity_sigma_rad =
      std::sqrt(solution.parameter_covariance.topLeftCorner<2, 2>().trace() / 2.0);
  if (!(result.gravity_sigma_rad < options.max_gravity_sigma_rad)) {
    result.reason = "the direction of gravity is uncertain by " +
                    std::to_string(result.gravity_sigma_rad) + " rad";
    return result;
  }
  result.gravity_body0 = options.gravity_magnitude * solution.gravity.normalized();
  result.bias.accel = solution.accel_bias;
  result.states = world_states(problem, solution, visual, inertial, result.bias);
  result.success = true;
  return result;
}

}  // namespace imslam::pgo

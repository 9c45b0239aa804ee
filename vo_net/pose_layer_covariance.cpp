#include "vo_net/pose_layer_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace imslam::vo::detail {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kMinReciprocalCondition = 1e-9;

double measured_components(const Correspondence& c) {
  return (c.flow_information.trace() > 0.0 ? 2.0 : 0.0) +
         (c.disparity1_information > 0.0 ? 1.0 : 0.0);  // disparity0 pays for the unknown depth
}

}  // namespace

std::optional<Vector6> solve_positive(const Matrix6& H, const Vector6& g) {
  const Vector6 diagonal = H.diagonal();
  if (!(diagonal.minCoeff() > 0.0)) return std::nullopt;
  const Vector6 scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Matrix6> factor(scale.asDiagonal() * H * scale.asDiagonal());
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Vector6 x = scale.asDiagonal() * factor.solve(scale.asDiagonal() * g);
  if (!x.allFinite()) return std::nullopt;
  return x;
}

std::optional<Spread> spread_of(const Problem& problem, const ReducedSystem& system) {
  const Matrix6 H = system.H.topLeftCorner<6, 6>();
  const Vector6 diagonal = H.diagonal();
  if (!H.allFinite() || !(diagonal.minCoeff() > 0.0)) return std::nullopt;
  const Vector6 scale = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix6 normalised = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(normalised);
  if (!(eigen.eigenvalues()[0] > kMinReciprocalCondition * eigen.eigenvalues()[5])) {
    return std::nullopt;
  }
  double slopes = 0.0;
  double squares = 0.0;
  double bends = 0.0;
  double components = 0.0;
  for (std::size_t k = 0; k < system.points.size(); ++k) {
    const detail::EliminatedPoint& p = system.points[k];
    if (p.curvature <= 0.0) continue;
    const Correspondence& c = problem.correspondences[k];
    const double n = measured_components(c);
    slopes += n * p.slope;
    squares += c.weight * p.slope * p.slope * p.s;
    bends += n * p.slope + 2.0 * p.bend * p.s;
    components += n;
  }
  if (!(bends > 0.0) || !(components > 6.0)) return std::nullopt;
  Spread spread;
  const double lost_freedom = components / (components - 6.0);
  spread.factor = std::max(lost_freedom * slopes * squares / (bends * bends), 1e-12);
  const Matrix6 inverse = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                          eigen.eigenvectors().transpose();
  spread.covariance = spread.factor * (scale.asDiagonal() * inverse * scale.asDiagonal());
  return spread;
}

}  // namespace imslam::vo::detail

#include "slam/system/measurement_coordinates.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::system {
namespace {

using Coordinates = MeasurementCoordinates;
using Vector = Eigen::VectorXd;
template <int kSize>
using VectorOf = Eigen::Matrix<double, kSize, 1>;
template <int kSize>
using MatrixOf = Eigen::Matrix<double, kSize, kSize>;

// Lower triangle, row by row, and its symmetric matrix.

template <int kSize>
MatrixOf<kSize> symmetric(const Vector& lower) {
  MatrixOf<kSize> S;
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < kSize; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) S(i, j) = S(j, i) = lower(next++);
  }
  return S;
}

template <int kSize>
Vector lower_triangle(const MatrixOf<kSize>& S) {
  Vector lower(kSize * (kSize + 1) / 2);
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < kSize; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) lower(next++) = S(i, j);
  }
  return lower;
}

/// An entry off the diagonal stands for two: 2 in a slope by the triangle, 1 in one by the matrix.
template <int kSize>
MatrixOf<kSize> times_off_diagonal(MatrixOf<kSize> M, double factor) {
  const VectorOf<kSize> diagonal = M.diagonal();
  M *= factor;
  M.diagonal() = diagonal;
  return M;
}

/// Sigma = W_0^-1 S W_0^-T  has the square root of information  C^-1 W_0,  S = C C^T.
template <typename Edge, int kSize>
bool set_covariance(const MatrixOf<kSize>& W0, const MatrixOf<kSize>& S, Edge& edge) {
  const Eigen::LLT<MatrixOf<kSize>> llt(S);
  if (!S.allFinite() || llt.info() != Eigen::Success) return false;
  edge.sqrt_information = llt.matrixL().solve(W0);
  const MatrixOf<kSize> B =
      W0.template triangularView<Eigen::Lower>().solve(MatrixOf<kSize>(llt.matrixL()));
  edge.motion.covariance = B * B.transpose();
  return edge.sqrt_information.allFinite();
}

template <int kSize>
Vector numbers(const VectorOf<kSize>& step,
               const MatrixOf<kSize>& W0,
               const MatrixOf<kSize>& covariance) {
  Vector z(kSize + kSize * (kSize + 1) / 2);
  z << step, lower_triangle<kSize>(W0 * covariance * W0.transpose());
  return z;
}

/// dL/dz of one edge. J: slope of the measurement's right perturbation by its numbers.
template <int kSize>
Vector slope(const pgo::EdgeGradient<kSize>& gradient,
             const MatrixOf<kSize>& W0,
             const MatrixOf<kSize>& J) {
  const MatrixOf<kSize> B =
      W0.template triangularView<Eigen::Lower>().solve(MatrixOf<kSize>::Identity());
  const MatrixOf<kSize> dS = B.transpose() * gradient.covariance * B;
  Vector dz(kSize + kSize * (kSize + 1) / 2);
  dz << J.transpose() * gradient.motion, lower_triangle<kSize>(times_off_diagonal<kSize>(dS, 2.0));
  return dz;
}

template <int kSize>
pgo::EdgeGradient<kSize> gradient_of(const Vector& dz,
                                     const MatrixOf<kSize>& W0,
                                     const MatrixOf<kSize>& J) {
  pgo::EdgeGradient<kSize> gradient;
  gradient.motion = J.transpose().partialPivLu().solve(dz.head<kSize>());
  const MatrixOf<kSize> dS =
      times_off_diagonal<kSize>(symmetric<kSize>(dz.tail(dz.size() - kSize)), 0.5);
  gradient.covariance = W0.transpose() * dS * W0;
  return gradient;
}

MatrixOf<6> visual_slope(const Vector& z, Eigen::Index at) {
  return lie::SE3d::right_jacobian(z.segment<6>(at));
}

MatrixOf<9> inertial_slope(const Vector& z, Eigen::Index at) {
  MatrixOf<9> J = MatrixOf<9>::Identity();
  J.topLeftCorner<3, 3>() = lie::SO3d::right_jacobian(z.segment<3>(at));
  return J;
}

void set_motion(const Vector& numbers, const RelativeMotion& origin, RelativeMotion& motion) {
  motion.T_body0_body1 = origin.T_body0_body1 * lie::SE3d::exp(numbers.head<6>());
}

void set_motion(const Vector& numbers, const ImuMotion& origin, ImuMotion& motion) {
  motion.dR = origin.dR * lie::SO3d::exp(numbers.head<3>());
  motion.dv = origin.dv + numbers.segment<3>(3);
  motion.dp = origin.dp + numbers.segment<3>(6);
}

template <int kSize, typename Edge>
bool set_edge(const Vector& numbers, const Edge& origin, Edge& edge) {
  set_motion(numbers, origin.motion, edge.motion);
  return numbers.head<kSize>().allFinite() &&
         set_covariance<Edge, kSize>(origin.sqrt_information,
                                     symmetric<kSize>(numbers.tail(numbers.size() - kSize)), edge);
}

pgo::BiasPrior prior_of(const Vector& numbers, pgo::BiasPrior prior) {
  prior.bias = {numbers.head<3>(), numbers.segment<3>(3)};
  prior.sigma = {numbers.segment<3>(6).array().exp(), numbers.tail<3>().array().exp()};
  return prior;
}

}  // namespace

MeasurementCoordinates::MeasurementCoordinates(const pgo::GraphData& data)
    : visual_(data.visual_edges), inertial_(data.inertial_edges), bias_priors_(data.bias_priors) {}

Eigen::Index MeasurementCoordinates::visual(std::size_t edge) const {
  return kVisual * static_cast<Eigen::Index>(edge);
}

Eigen::Index MeasurementCoordinates::inertial(std::size_t edge) const {
  return visual(visual_.size()) + kInertial * static_cast<Eigen::Index>(edge);
}

Eigen::Index MeasurementCoordinates::bias_prior(std::size_t prior) const {
  return inertial(inertial_.size()) + kBiasPrior * static_cast<Eigen::Index>(prior);
}

Vector MeasurementCoordinates::origin() const {
  Vector z(size());
  for (std::size_t e = 0; e < visual_.size(); ++e) {
    z.segment<kVisual>(visual(e)) << VectorOf<6>::Zero(),
        lower_triangle<6>(MatrixOf<6>::Identity());
  }
  for (std::size_t e = 0; e < inertial_.size(); ++e) {
    z.segment<kInertial>(inertial(e)) << VectorOf<9>::Zero(),
        lower_triangle<9>(MatrixOf<9>::Identity());
  }
  for (std::size_t k = 0; k < bias_priors_.size(); ++k) {
    const pgo::BiasPrior& prior = bias_priors_[k];
    z.segment<kBiasPrior>(bias_prior(k)) << prior.bias.gyro, prior.bias.accel,
        prior.sigma.gyro.array().log().matrix(), prior.sigma.accel.array().log().matrix();
  }
  return z;
}

std::string MeasurementCoordinates::apply(const Vector& z, pgo::GraphData& data) const {
  expects(z.size() == size() && data.visual_edges.size() == visual_.size() &&
              data.inertial_edges.size() == inertial_.size() &&
              data.bias_priors.size() == bias_priors_.size(),
          "measurement coordinates: z or graph of another size");
  std::vector<pgo::VisualEdge> visual_edges = data.visual_edges;
  std::vector<pgo::InertialEdge> inertial_edges = data.inertial_edges;
  const std::string complaint = ": not finite, or its covariance is not positive";
  for (std::size_t e = 0; e < visual_.size(); ++e) {
    if (!set_edge<6>(z.segment<kVisual>(visual(e)), visual_[e], visual_edges[e])) {
      return "visual edge " + std::to_string(e) + complaint;
    }
  }
  for (std::size_t e = 0; e < inertial_.size(); ++e) {
    if (!set_edge<9>(z.segment<kInertial>(inertial(e)), inertial_[e], inertial_edges[e])) {
      return "inertial edge " + std::to_string(e) + complaint;
    }
  }
  if (!z.tail(size() - bias_prior(0)).allFinite()) return "bias priors: not finite";
  data.visual_edges = std::move(visual_edges);
  data.inertial_edges = std::move(inertial_edges);
  for (std::size_t k = 0; k < bias_priors_.size(); ++k) {
    data.bias_priors[k] = prior_of(z.segment<kBiasPrior>(bias_prior(k)), bias_priors_[k]);
  }
  return "";
}

Vector MeasurementCoordinates::pull_back(const Vector& z,
                                         const pgo::MeasurementGradient& gradient) const {
  Vector dz(size());
  for (std::size_t e = 0; e < visual_.size(); ++e) {
    dz.segment<kVisual>(visual(e)) =
        slope<6>(gradient.visual[e], visual_[e].sqrt_information, visual_slope(z, visual(e)));
  }
  for (std::size_t e = 0; e < inertial_.size(); ++e) {
    dz.segment<kInertial>(inertial(e)) = slope<9>(
        gradient.inertial[e], inertial_[e].sqrt_information, inertial_slope(z, inertial(e)));
  }
  for (std::size_t k = 0; k < bias_priors_.size(); ++k) {
    dz.segment<kBiasPrior>(bias_prior(k)) << gradient.bias_priors[k].value,
        gradient.bias_priors[k].log_sigma;
  }
  return dz;
}

Vector MeasurementCoordinates::visual_numbers(std::size_t edge,
                                              const RelativeMotion& motion) const {
  const pgo::VisualEdge& origin = visual_[edge];
  const lie::SE3d step = origin.motion.T_body0_body1.inverse() * motion.T_body0_body1;
  return numbers<6>(step.log(), origin.sqrt_information, motion.covariance);
}

Vector MeasurementCoordinates::inertial_numbers(std::size_t edge, const ImuMotion& motion) const {
  const pgo::InertialEdge& origin = inertial_[edge];
  VectorOf<9> step;
  step << (origin.motion.dR.inverse() * motion.dR).log(), motion.dv - origin.motion.dv,
      motion.dp - origin.motion.dp;
  return numbers<9>(step, origin.sqrt_information, motion.covariance);
}

pgo::EdgeGradient<6> MeasurementCoordinates::visual_gradient(std::size_t edge,
                                                             const Vector& z,
                                                             const Vector& dz) const {
  return gradient_of<6>(dz.segment<kVisual>(visual(edge)), visual_[edge].sqrt_information,
                        visual_slope(z, visual(edge)));
}

pgo::EdgeGradient<9> MeasurementCoordinates::inertial_gradient(std::size_t edge,
                                                               const Vector& z,
                                                               const Vector& dz) const {
  return gradient_of<9>(dz.segment<kInertial>(inertial(edge)), inertial_[edge].sqrt_information,
                        inertial_slope(z, inertial(edge)));
}

}  // namespace imslam::system

#include "pgo/residual_posterior.hpp"

#include "pgo/linear_system.hpp"
#include "pgo/selected_inverse.hpp"

namespace imslam::pgo {
namespace {

using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// J_e P J_e^T of the rows from `first`: all pairs of an edge's columns are on the pattern of H.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> spread(const RowMajor& J,
                                           Eigen::Index first,
                                           const SelectedInverse& P) {
  std::vector<Eigen::Index> columns;
  for (RowMajor::InnerIterator entry(J, first); entry; ++entry) columns.push_back(entry.col());
  const auto count = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd dense(kSize, count);
  Eigen::MatrixXd covariance(count, count);
  for (Eigen::Index a = 0; a < count; ++a) {
    const Eigen::Index column = columns[static_cast<std::size_t>(a)];
    for (Eigen::Index row = 0; row < kSize; ++row) dense(row, a) = J.coeff(first + row, column);
    for (Eigen::Index b = 0; b <= a; ++b) {
      covariance(a, b) = covariance(b, a) = P(column, columns[static_cast<std::size_t>(b)]);
    }
  }
  return dense * covariance * dense.transpose();
}

Eigen::Matrix<double, 6, 1> spread_of(const BiasPrior& prior,
                                      const LinearSystem& system,
                                      const SelectedInverse& P) {
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << prior.sigma.gyro, prior.sigma.accel;
  Eigen::Matrix<double, 6, 1> result = Eigen::Matrix<double, 6, 1>::Zero();
  for (std::size_t b = 0; b < system.blocks.size(); ++b) {
    if (!(system.blocks[b] == BlockId{BlockId::Kind::kBias, prior.state})) continue;
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Eigen::Index column = system.offsets[b] + i;
      result(i) = P(column, column) / (sigma(i) * sigma(i));
    }
  }
  return result;
}

}  // namespace

std::optional<ResidualPosterior> residual_posterior(const PoseVelocityGraph& graph) {
  const GraphData& data = graph.data();
  if (!unsolvable_reason(data).empty()) return std::nullopt;
  GraphProblem problem(data, graph.options());
  const LinearSystem system =
      linearize(problem, estimated_blocks(problem, static_cast<int>(data.states.size())));
  const auto P = SelectedInverse::factorize(system.J.transpose() * system.J);
  if (!P) return std::nullopt;

  std::vector<ceres::ResidualBlockId> edges = problem.visual_residuals();
  edges.insert(edges.end(), problem.inertial_residuals().begin(),
               problem.inertial_residuals().end());
  ResidualPosterior result;
  result.half_log_determinant = 0.5 * P->log_determinant();
  if (!edges.empty()) {
    const RowMajor J = linearize(problem, system.blocks, edges).J;
    Eigen::Index row = 0;
    for (std::size_t e = 0; e < data.visual_edges.size(); ++e, row += 6) {
      result.visual.push_back(spread<6>(J, row, *P));
    }
    for (std::size_t e = 0; e < data.inertial_edges.size(); ++e, row += 9) {
      result.inertial.push_back(spread<9>(J, row, *P));
    }
  }
  for (const BiasPrior& prior : data.bias_priors) {
    result.bias_priors.push_back(spread_of(prior, system, *P));
  }
  return result;
}

void ResidualPosterior::add_to(const GraphData& data, MeasurementGradient& gradient) const {
  for (std::size_t e = 0; e < visual.size(); ++e) {
    const auto& W = data.visual_edges[e].sqrt_information;
    gradient.visual[e].covariance -= 0.5 * W.transpose() * visual[e] * W;
  }
  for (std::size_t e = 0; e < inertial.size(); ++e) {
    const auto& W = data.inertial_edges[e].sqrt_information;
    gradient.inertial[e].covariance -= 0.5 * W.transpose() * inertial[e] * W;
  }
  for (std::size_t k = 0; k < bias_priors.size(); ++k) {
    gradient.bias_priors[k].log_sigma -= bias_priors[k];
  }
}

}  // namespace imslam::pgo

#include "pgo/posterior.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <utility>

#include "pgo/linear_system.hpp"
#include "pgo/selected_inverse.hpp"
#include "slam/base/error.hpp"

namespace imslam::pgo {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// J P J^T of some rows of a sparse J; P has an entry wherever two columns meet in a row.
template <int kRows>
Eigen::Matrix<double, kRows, kRows> spread_of_rows(const RowMajor& J,
                                                   Eigen::Index first,
                                                   const SelectedInverse& P) {
  std::vector<int> columns;
  for (int r = 0; r < kRows; ++r) {
    for (RowMajor::InnerIterator it(J, first + r); it; ++it) {
      columns.push_back(static_cast<int>(it.col()));
    }
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::Matrix<double, kRows, Eigen::Dynamic> dense(kRows, n);
  Eigen::MatrixXd inverse(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (int r = 0; r < kRows; ++r) {
      dense(r, a) = J.coeff(first + r, columns[static_cast<std::size_t>(a)]);
    }
    for (Eigen::Index b = 0; b <= a; ++b) {
      inverse(a, b) = P(columns[static_cast<std::size_t>(a)], columns[static_cast<std::size_t>(b)]);
      inverse(b, a) = inverse(a, b);
    }
  }
  const Eigen::Matrix<double, kRows, kRows> S = dense * inverse * dense.transpose();
  return 0.5 * (S + S.transpose());
}

/// W^-1 S W^-T for whitened S and lower triangular W.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> unwhitened(const Eigen::Matrix<double, kSize, kSize>& S,
                                               const Eigen::Matrix<double, kSize, kSize>& W) {
  const auto L = W.template triangularView<Eigen::Lower>();
  const Eigen::Matrix<double, kSize, kSize> half = L.solve(S);
  return L.solve(Eigen::Matrix<double, kSize, kSize>(half.transpose()));
}

}  // namespace

class Posterior::System {
 public:
  LinearSystem linear;
  PosteriorSpread spread;
  Eigen::SimplicialLDLT<Sparse> factor;
  Eigen::VectorXd scale;  ///< H was scaled to a unit diagonal

  /// First column of a block, or -1 if it is not estimated.
  Eigen::Index column_of(BlockId::Kind kind, int state) const {
    for (std::size_t b = 0; b < linear.blocks.size(); ++b) {
      if (linear.blocks[b] == BlockId{kind, state}) return linear.offsets[b];
    }
    return -1;
  }

  /// P at these columns; those of -1 have zero rows.
  Eigen::MatrixXd covariance(const std::vector<Eigen::Index>& columns) const {
    const auto n = static_cast<Eigen::Index>(columns.size());
    Eigen::MatrixXd units = Eigen::MatrixXd::Zero(linear.columns(), n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index c = columns[static_cast<std::size_t>(i)];
      if (c >= 0) units(c, i) = scale[c];
    }
    const Eigen::MatrixXd solved = scale.asDiagonal() * factor.solve(units);
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index c = columns[static_cast<std::size_t>(i)];
      if (c >= 0) P.row(i) = solved.row(c);
    }
    return 0.5 * (P + P.transpose());
  }
};

namespace {

/// All visual edges, then all inertial ones, then nothing else.
std::vector<ceres::ResidualBlockId> edges_of(const GraphProblem& graph) {
  std::vector<ceres::ResidualBlockId> ids = graph.visual_residuals();
  ids.insert(ids.end(), graph.inertial_residuals().begin(), graph.inertial_residuals().end());
  return ids;
}

/// rho' of a visual edge: its rows of J are those of the factor times the root of that.
double kernel_weight(const PoseVelocityGraph& graph,
                     const VisualEdge& edge,
                     const ceres::LossFunction* loss) {
  if (loss == nullptr) return 1.0;
  const GraphData& data = graph.data();
  const auto residual = RelativePoseFactor(edge.motion, edge.sqrt_information)
                            .residual(data.states[static_cast<std::size_t>(edge.from)].nav.T_world_body,
                                      data.states[static_cast<std::size_t>(edge.to)].nav.T_world_body,
                                      data.globals.disparity_offset, data.globals.focal_error);
  double rho[3];
  loss->Evaluate(residual.squaredNorm(), rho);
  return std::max(rho[1], 1e-6);
}

void append_columns(Eigen::Index first, int count, std::vector<Eigen::Index>& columns) {
  for (int d = 0; d < count; ++d) columns.push_back(first < 0 ? -1 : first + d);
}

}  // namespace

Posterior::Posterior(std::unique_ptr<System> system) : system_(std::move(system)) {}
Posterior::Posterior(Posterior&&) noexcept = default;
Posterior& Posterior::operator=(Posterior&&) noexcept = default;
Posterior::~Posterior() = default;

std::optional<Posterior> Posterior::of(const PoseVelocityGraph& graph) {
  const GraphData& data = graph.data();
  if (!unsolvable_reason(data).empty()) return std::nullopt;
  GraphProblem problem(data, graph.options());
  auto system = std::make_unique<System>();
  const auto blocks = estimated_blocks(problem, static_cast<int>(data.states.size()));
  system->linear = linearize(problem, blocks);
  const Sparse H = system->linear.J.transpose() * system->linear.J;
  system->scale = Eigen::VectorXd(H.diagonal()).cwiseSqrt().cwiseInverse();
  if (!system->scale.allFinite()) return std::nullopt;
  system->factor.compute(system->scale.asDiagonal() * H * system->scale.asDiagonal());
  const auto inverse = SelectedInverse::factorize(H);
  if (system->factor.info() != Eigen::Success || !inverse) return std::nullopt;

  const RowMajor J = linearize(problem, blocks, edges_of(problem)).J;
  const auto loss = make_loss(graph.options());
  Eigen::Index row = 0;
  for (const VisualEdge& edge : data.visual_edges) {
    const double weight = kernel_weight(graph, edge, loss.get());
    system->spread.visual.push_back(
        unwhitened<6>(spread_of_rows<6>(J, row, *inverse), edge.sqrt_information) / weight);
    row += 6;
  }
  for (const InertialEdge& edge : data.inertial_edges) {
    system->spread.inertial.push_back(
        unwhitened<9>(spread_of_rows<9>(J, row, *inverse), edge.sqrt_information));
    row += 9;
  }
  return Posterior(std::move(system));
}

const PosteriorSpread& Posterior::spread() const { return system_->spread; }

Eigen::Matrix<double, 18, 18> Posterior::joint(int state0, int state1) const {
  std::vector<Eigen::Index> columns;
  for (const int state : {state0, state1}) {
    append_columns(system_->column_of(BlockId::Kind::kPose, state), 6, columns);
    append_columns(system_->column_of(BlockId::Kind::kVelocity, state), 3, columns);
  }
  return system_->covariance(columns);
}

Eigen::Matrix<double, 6, 6> Posterior::bias(int state) const {
  std::vector<Eigen::Index> columns;
  append_columns(system_->column_of(BlockId::Kind::kBias, state), 6, columns);
  return system_->covariance(columns);
}

}  // namespace imslam::pgo

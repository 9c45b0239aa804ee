#include "pgo/posterior.hpp"

#include <Eigen/SparseCholesky>
#include <utility>
#include <vector>

#include "pgo/linear_system.hpp"

namespace imslam::pgo {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

}  // namespace

class Posterior::System {
 public:
  LinearSystem linear;
  ResidualPosterior residuals;
  Eigen::SimplicialLDLT<Sparse> factor;
  Eigen::VectorXd scale;  ///< J^T J was scaled to a unit diagonal

  /// Columns of a block; -1 each if it is not estimated.
  void append_columns(BlockId::Kind kind,
                      int state,
                      int count,
                      std::vector<Eigen::Index>& columns) const {
    Eigen::Index first = -1;
    for (std::size_t b = 0; b < linear.blocks.size(); ++b) {
      if (linear.blocks[b] == BlockId{kind, state}) first = linear.offsets[b];
    }
    for (int d = 0; d < count; ++d) columns.push_back(first < 0 ? -1 : first + d);
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

Posterior::Posterior(std::unique_ptr<System> system) : system_(std::move(system)) {}
Posterior::Posterior(Posterior&&) noexcept = default;
Posterior& Posterior::operator=(Posterior&&) noexcept = default;
Posterior::~Posterior() = default;

std::optional<Posterior> Posterior::of(const PoseVelocityGraph& graph) {
  auto residuals = residual_posterior(graph);
  if (!residuals) return std::nullopt;
  auto system = std::make_unique<System>();
  system->residuals = std::move(*residuals);
  GraphProblem problem(graph.data(), graph.options());
  system->linear =
      linearize(problem, estimated_blocks(problem, static_cast<int>(graph.states().size())));
  const Sparse H = system->linear.J.transpose() * system->linear.J;
  system->scale = Eigen::VectorXd(H.diagonal()).cwiseSqrt().cwiseInverse();
  if (!system->scale.allFinite()) return std::nullopt;
  system->factor.compute(system->scale.asDiagonal() * H * system->scale.asDiagonal());
  if (system->factor.info() != Eigen::Success) return std::nullopt;
  return Posterior(std::move(system));
}

const ResidualPosterior& Posterior::residuals() const { return system_->residuals; }

Eigen::Matrix<double, 18, 18> Posterior::joint(int state0, int state1) const {
  std::vector<Eigen::Index> columns;
  for (const int state : {state0, state1}) {
    system_->append_columns(BlockId::Kind::kPose, state, 6, columns);
    system_->append_columns(BlockId::Kind::kVelocity, state, 3, columns);
  }
  return system_->covariance(columns);
}

}  // namespace imslam::pgo

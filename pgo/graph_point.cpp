#include "pgo/graph_point.hpp"

#include <algorithm>
#include <tuple>

#include "pgo/ceres_solve.hpp"
#include "pgo/linear_system.hpp"
#include "pgo/pose_velocity_graph.hpp"
#include "slam/base/error.hpp"

namespace imslam::pgo {
namespace {

using Residuals = std::vector<ceres::ResidualBlockId>;

void select(const Residuals& all, const std::vector<char>& flags, Residuals& chosen) {
  expects(flags.size() == all.size(), "edge selection: one flag for each edge");
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (flags[i] != 0) chosen.push_back(all[i]);
  }
}

/// Place in the order of estimated_blocks().
std::tuple<bool, int, BlockId::Kind> rank(const BlockId& id) {
  return {id.global(), id.global() ? 0 : id.state, id.kind};
}

}  // namespace

GraphPoint::GraphPoint(const GraphData& data, const GraphOptions& options)
    : problem_(std::make_unique<GraphProblem>(data, options)),
      blocks_(estimated_blocks(*problem_, static_cast<int>(data.states.size()))),
      offsets_{0},
      unsolvable_(unsolvable_reason(data)) {
  for (const BlockId& id : blocks_) offsets_.push_back(offsets_.back() + tangent_size(id.kind));
}

GraphPoint::~GraphPoint() = default;

Eigen::Index GraphPoint::offset(const BlockId& id) const {
  const auto before = [](const BlockId& a, const BlockId& b) { return rank(a) < rank(b); };
  const auto found = std::lower_bound(blocks_.begin(), blocks_.end(), id, before);
  if (found == blocks_.end() || !(*found == id)) return -1;
  return offsets_[static_cast<std::size_t>(found - blocks_.begin())];
}

SolveReport GraphPoint::solve(const SolverOptions& options) {
  options.validate();
  SolveReport report;
  report.reason = unsolvable_;
  if (!report.reason.empty()) return report;
  return solve_with_ceres(problem_->problem(), options);
}

void GraphPoint::move(const Eigen::VectorXd& tau) {
  expects(tau.size() == size(), "graph point: a tangent must be as long as the point's");
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    double* const x = problem_->block(blocks_[b]);
    const double* const step = tau.data() + offsets_[b];
    const auto count = static_cast<std::size_t>(problem_->problem().ParameterBlockSize(x));
    const ceres::Manifold* const manifold = problem_->problem().GetManifold(x);
    if (manifold == nullptr) {
      for (std::size_t i = 0; i < count; ++i) x[i] += step[i];
      continue;
    }
    const std::vector<double> before(x, x + count);
    manifold->Plus(before.data(), step, x);
  }
}

Eigen::VectorXd GraphPoint::numbers() const {
  std::vector<double> all;
  for (const BlockId& id : blocks_) {
    const double* const x = problem_->block(id);
    all.insert(all.end(), x, x + problem_->problem().ParameterBlockSize(x));
  }
  return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

void GraphPoint::set_numbers(const Eigen::VectorXd& numbers) {
  const double* next = numbers.data();
  for (const BlockId& id : blocks_) {
    double* const x = problem_->block(id);
    const int count = problem_->problem().ParameterBlockSize(x);
    expects(next + count <= numbers.data() + numbers.size(), "graph point: too few numbers");
    std::copy(next, next + count, x);
    next += count;
  }
}

bool GraphPoint::store(GraphData& data) const { return problem_->store(data); }

Eigen::VectorXd GraphPoint::gradient_of(const Residuals& residuals) const {
  ceres::Problem::EvaluateOptions options;
  options.residual_blocks = residuals;
  for (const BlockId& id : blocks_) options.parameter_blocks.push_back(problem_->block(id));
  std::vector<double> slope;
  problem_->problem().Evaluate(options, nullptr, nullptr, &slope, nullptr);
  expects(static_cast<Eigen::Index>(slope.size()) == size(), "graph point: gradient of odd size");
  return Eigen::Map<Eigen::VectorXd>(slope.data(), size());
}

Eigen::VectorXd GraphPoint::gradient() const { return gradient_of({}); }

Eigen::VectorXd GraphPoint::gradient(const EdgeSelection& edges) const {
  Residuals residuals;
  select(problem_->visual_residuals(), edges.visual, residuals);
  select(problem_->inertial_residuals(), edges.inertial, residuals);
  if (residuals.empty()) return Eigen::VectorXd::Zero(size());  // none would mean all to Ceres
  return gradient_of(residuals);
}

Eigen::SparseMatrix<double> GraphPoint::gauss_newton_hessian() const {
  const LinearSystem system = linearize(*problem_, blocks_);
  return system.J.transpose() * system.J;
}

}  // namespace imslam::pgo

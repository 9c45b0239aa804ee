// Time of one Levenberg-Marquardt iteration of our graph (VO 6 + IMU 9 residuals per interval,
// pose, velocity and bias per state) beside the least that any solver must do: one
// block-tridiagonal Cholesky factorisation and solve of the same chain, with fixed-size blocks and
// nothing else.
#include <benchmark/benchmark.h>

#include <Eigen/Cholesky>
#include <map>
#include <vector>

#include "pgo/linear_system.hpp"
#include "tests/pgo/synthetic.hpp"

namespace imslam {
namespace {

constexpr int kBlock = 15;
using Block = Eigen::Matrix<double, kBlock, kBlock>;
using BlockVector = Eigen::Matrix<double, kBlock, 1>;

const pgo::PoseVelocityGraph& chain(int states) {
  static std::map<int, pgo::PoseVelocityGraph> graphs;
  const auto found = graphs.find(states);
  if (found != graphs.end()) return found->second;
  pgo::PoseVelocityGraph graph =
      testing::chain_graph(testing::wavy_states(states, 0.05), {}, true, 1e-3);
  return graphs.emplace(states, std::move(graph)).first->second;
}

void OurIteration(benchmark::State& state) {
  const auto states = static_cast<int>(state.range(0));
  pgo::SolverOptions options;
  options.max_iterations = 10;  // the symbolic factorisation of the first one is shared by all
  options.function_tolerance = 0.0;
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 0.0;
  for (auto _ : state) {
    pgo::PoseVelocityGraph graph = chain(states);
    const SolveReport report = graph.solve(options);
    state.SetIterationTime(1e-3 * report.ms_per_iteration);
  }
  state.SetComplexityN(states);
}
BENCHMARK(OurIteration)
    ->RangeMultiplier(10)
    ->Range(1000, 100000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Complexity();

/// The normal equations of the chain, block by block.
struct BlockTridiagonal {
  std::vector<Block> diagonal;
  std::vector<Block> below;  ///< below[i]: row i + 1, column i
  std::vector<BlockVector> gradient;
};

BlockTridiagonal normal_equations(const pgo::PoseVelocityGraph& graph) {
  pgo::GraphProblem problem(graph.data(), graph.options());
  const auto states = static_cast<int>(graph.states().size());
  const pgo::LinearSystem system = linearize(problem, estimated_blocks(problem, states));
  const Eigen::SparseMatrix<double> H = system.J.transpose() * system.J;
  const Eigen::VectorXd g = system.J.transpose() * system.residual;
  BlockTridiagonal chain;
  for (Eigen::Index i = 0; i < states; ++i) {
    chain.diagonal.emplace_back(H.block(kBlock * i, kBlock * i, kBlock, kBlock));
    chain.gradient.emplace_back(g.segment<kBlock>(kBlock * i));
    if (i + 1 == states) break;
    chain.below.emplace_back(H.block(kBlock * (i + 1), kBlock * i, kBlock, kBlock));
  }
  return chain;
}

/// Solves in place: on return `gradient` holds H^-1 g. `factors`: scratch.
void solve(const BlockTridiagonal& chain,
           std::vector<Eigen::LLT<Block>>& factors,
           std::vector<Block>& below,
           std::vector<BlockVector>& x) {
  const std::size_t count = chain.diagonal.size();
  x = chain.gradient;
  Block D = chain.diagonal[0];
  for (std::size_t i = 0; i < count; ++i) {
    factors[i].compute(D);
    factors[i].matrixL().solveInPlace(x[i]);
    if (i + 1 == count) break;
    below[i] = chain.below[i].transpose();  // L_ii^-1 B^T, so that C = its transpose
    factors[i].matrixL().solveInPlace(below[i]);
    D = chain.diagonal[i + 1];
    D.noalias() -= below[i].transpose() * below[i];
    x[i + 1].noalias() -= below[i].transpose() * x[i];
  }
  for (std::size_t i = count; i-- > 0;) {
    if (i + 1 < count) x[i].noalias() -= below[i] * x[i + 1];
    factors[i].matrixU().solveInPlace(x[i]);
  }
}

void BareBlockTridiagonalSolve(benchmark::State& state) {
  const auto states = static_cast<int>(state.range(0));
  const BlockTridiagonal system = normal_equations(chain(states));
  std::vector<Eigen::LLT<Block>> factors(system.diagonal.size());
  std::vector<Block> below(system.below.size());
  std::vector<BlockVector> x;
  for (auto _ : state) {
    solve(system, factors, below, x);
    benchmark::DoNotOptimize(x.data());
  }
  // It must be the right answer, or its time means nothing.
  double worst = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    BlockVector r = system.diagonal[i] * x[i] - system.gradient[i];
    if (i > 0) r += system.below[i - 1] * x[i - 1];
    if (i + 1 < x.size()) r += system.below[i].transpose() * x[i + 1];
    worst = std::max(worst, r.norm() / (1.0 + system.gradient[i].norm()));
  }
  if (!(worst < 1e-3)) state.SkipWithError("the bare solve is wrong");
  state.SetComplexityN(states);
}
BENCHMARK(BareBlockTridiagonalSolve)
    ->RangeMultiplier(10)
    ->Range(1000, 100000)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();

}  // namespace
}  // namespace imslam

BENCHMARK_MAIN();

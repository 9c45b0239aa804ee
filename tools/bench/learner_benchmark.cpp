// One step against unrolling on one pose graph: time and memory of a gradient, solve included.
// The way back through T steps is unrolled/T less solve_only/T. One step solves by as many of the
// same steps as are unrolled, so the ratio is that of the ways back.
#include <benchmark/benchmark.h>

#include "slam/learner/gradient_strategy.hpp"
#include "slam/learner/unrolled.hpp"
#include "tests/slam/learner/pose_graph_task.hpp"

namespace {

using imslam::learner::Vector;
using imslam::learner::testing::PoseGraphTask;

constexpr int kPoses = 50;

Vector solve_by_steps(PoseGraphTask& task, int steps) {
  Vector phi = task.first_guess();
  for (int t = 0; t < steps; ++t) phi = task.step(phi, task.measured);
  task.adopt(phi, task.measured);
  return phi;
}

void solve_only(benchmark::State& state) {
  PoseGraphTask task(kPoses, 0.02);
  for (auto _ : state) {
    benchmark::DoNotOptimize(solve_by_steps(task, static_cast<int>(state.range(0))));
  }
}
BENCHMARK(solve_only)->Arg(10)->Arg(20)->Arg(50);

void one_step(benchmark::State& state) {
  PoseGraphTask task(kPoses, 0.02);
  for (auto _ : state) {
    solve_by_steps(task, static_cast<int>(state.range(0)));
    benchmark::DoNotOptimize(task.cost_by_z());
  }
  state.counters["kept_bytes"] = 0;
}
BENCHMARK(one_step)->Arg(10)->Arg(20)->Arg(50);

void one_step_way_back(benchmark::State& state) {
  PoseGraphTask task(kPoses, 0.02);
  solve_by_steps(task, 20);
  for (auto _ : state) benchmark::DoNotOptimize(task.cost_by_z());
}
BENCHMARK(one_step_way_back);

void unrolled(benchmark::State& state) {
  PoseGraphTask task(kPoses, 0.02);
  const int steps = static_cast<int>(state.range(0));
  imslam::learner::Unrolled strategy(task, {steps, 0, 0.0});
  for (auto _ : state) {
    benchmark::DoNotOptimize(strategy(task.measured, imslam::Random(0)));
  }
  state.counters["kept_bytes"] =
      static_cast<double>(steps * task.first_guess().size()) * sizeof(double);
}
BENCHMARK(unrolled)->Arg(10)->Arg(20)->Arg(50);

}  // namespace

BENCHMARK_MAIN();

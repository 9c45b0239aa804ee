// What a gradient through the solved SLAM graph costs beside the solve itself: one step (U = L),
// implicit (U as published), states integrated out and
// unrolling, on one graph in one run. Wall time; other work on the
// machine makes single times long, never short: least and median of several. The unrolled steps
// share one factor, which is the cheapest solver that there is to unroll.
//
//   slam_gradient_benchmark [repeats = 5]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <vector>

#include "pgo/residual_posterior.hpp"
#include "slam/base/error.hpp"
#include "slam/learner/unrolled.hpp"
#include "slam/system/slam_solver_steps.hpp"
#include "tests/slam/system/contradictory_graph.hpp"

namespace imslam {
namespace {

using learner::Vector;

struct Times {
  double least_ms = 0.0;
  double median_ms = 0.0;
};

Times measure(int repeats, const std::function<void()>& work) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> ms;
  for (int i = 0; i < repeats; ++i) {
    const auto start = Clock::now();
    work();
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  std::sort(ms.begin(), ms.end());
  return {ms.front(), ms[ms.size() / 2]};
}

void print(const std::string& what, const Times& times, const Times& unit, double kept_mb) {
  fmt::print("  {:<34}{:>10.1f}{:>10.1f}{:>10.2f}{:>10.2f}\n", what, times.least_ms,
             times.median_ms, times.least_ms / unit.least_ms, kept_mb);
}

void compare(int states, int repeats) {
  const auto built = system::testing::contradictory_graph(states, true);
  pgo::GraphOptions options = built.options();
  options.estimate_gravity = false;  // unrolling needs groups
  const auto graph = [&] {
    pgo::PoseVelocityGraph copy(options);
    copy.data() = built.data();
    return copy;
  };
  system::SlamUpperOptions published;
  published.kind = system::UpperKind::kPublished;
  system::SlamSolverSteps task(built.data(), options, published);
  const Vector z = task.coordinates().origin();

  fmt::print("\n{} states, {} visual and {} inertial edges, {} unknowns, {} numbers in z\n", states,
             built.visual_edges().size(), built.inertial_edges().size(), task.point().size(),
             z.size());
  fmt::print("  {:<34}{:>10}{:>10}{:>10}{:>10}\n", "", "least ms", "median", "ratio", "kept MB");
  std::vector<pgo::PoseVelocityGraph> copies(static_cast<std::size_t>(repeats), graph());
  std::size_t next = 0;
  const Times plain = measure(repeats, [&] { copies[next++].solve(); });
  print("plain solve", plain, plain, 0.0);
  const Times exact = measure(repeats, [&] {
    task.restart();
    expects(task.solve(z).converged, "benchmark: no solution");
  });
  print("solve to rounding error", exact, plain, 0.0);
  print("  one step, way back", measure(repeats, [&] { task.cost_by_z(); }), plain, 0.0);
  print("  implicit, way back",
        measure(repeats,
                [&] {
                  const learner::UpperValue upper = task.upper_cost();
                  const auto q = task.hessian_solve(upper.by_phi);
                  expects(q.has_value(), "benchmark: no implicit solution");
                  task.mixed_product(*q);
                }),
        plain, 0.0);
  print("  states integrated out, way back",
        measure(repeats,
                [&] {
                  auto gradient = pgo::measurement_gradient(task.graph(), true);
                  pgo::residual_posterior(task.graph())->add_to(task.graph().data(), gradient);
                }),
        plain, 0.0);
  for (const int steps : {10, 20, 50}) {
    system::SlamSolverSteps fresh(built.data(), options, published);
    const double kept_mb =
        1e-6 * steps * static_cast<double>(fresh.first_guess().size()) * sizeof(double);
    const auto forward = [&] {
      Vector phi = fresh.first_guess();
      for (int t = 0; t < steps; ++t) phi = fresh.step(phi, z);
      return phi;
    };
    const Times solve = measure(repeats, forward);
    learner::Unrolled unrolled(fresh, {steps, 0, 0.0});
    const Times whole = measure(repeats, [&] { unrolled(z, Random(0)); });
    print(fmt::format("{} steps, solve", steps), solve, plain, 0.0);
    print("  unrolled, way back",
          {whole.least_ms - solve.least_ms, whole.median_ms - solve.median_ms}, plain, kept_mb);
  }
}

}  // namespace
}  // namespace imslam

int main(int argc, char** argv) {
  const int repeats = argc > 1 ? std::max(1, std::atoi(argv[1])) : 5;
  for (const int states : {200, 1000}) imslam::compare(states, repeats);
  return 0;
}

#include "pgo/sliding_window.hpp"

#include <string>
#include <utility>

#include "pgo/marginalization.hpp"
#include "slam/base/config.hpp"
#include "slam/base/error.hpp"

namespace imslam::pgo {

void WindowOptions::describe(Config& config) {
  config.field("states", states, "states in the sliding window");
  config.field("max_iterations", max_iterations, "most Levenberg-Marquardt steps per frame");
  config.field("function_tolerance", function_tolerance, "relative change of the cost to stop at");
  config.field("huber", kernel_width, "width of pgo.kernel in the window [standard deviations]");
}

void WindowOptions::validate() const {
  const auto require = [](bool valid, const std::string& what) {
    if (!valid) throw InputError(what, ExitCode::kUsage);
  };
  require(states >= 2 && states <= 10000,
          "window.states = " + std::to_string(states) + ": expected 2 to 10000");
  require(max_iterations >= 1 && max_iterations <= 1000,
          "window.max_iterations = " + std::to_string(max_iterations) + ": expected 1 to 1000");
  require(function_tolerance >= 0.0 && function_tolerance < 1.0,
          "window.function_tolerance = " + std::to_string(function_tolerance) +
              ": expected 0 or more and less than 1");
  require(
      kernel_width > 0.0 && kernel_width < 1e6,
      "window.huber = " + std::to_string(kernel_width) + ": expected more than 0, less than 1e6");
}

SlidingWindow::SlidingWindow(PoseVelocityGraph graph, const WindowOptions& options)
    : graph_(std::move(graph)), options_(options) {
  options.validate();
}

const State& SlidingWindow::state(int number) const {
  expects(inside(number), "sliding window: the state is not in the window");
  return graph_.states()[static_cast<std::size_t>(number - first_)];
}

int SlidingWindow::add_state(const State& guess) { return first_ + graph_.add_state(guess); }

bool SlidingWindow::add_visual_edge(int from, int to, const RelativeMotion& motion) {
  return inside(from) && inside(to) && graph_.add_visual_edge(from - first_, to - first_, motion);
}

bool SlidingWindow::add_imu_edge(int from, int to, const ImuMotion& motion) {
  return inside(from) && inside(to) && graph_.add_imu_edge(from - first_, to - first_, motion);
}

bool SlidingWindow::add_zero_velocity(int state, double sigma) {
  if (!inside(state)) return false;
  graph_.add_zero_velocity(state - first_, sigma);
  return true;
}

SolveReport SlidingWindow::update(int needed) {
  SolverOptions solver;
  solver.max_iterations = options_.max_iterations;
  solver.function_tolerance = options_.function_tolerance;
  solver.threads = 1;  // a window is too small to share
  const SolveReport report = graph_.solve(solver);
  const auto too_many = [&] {
    const int count = static_cast<int>(graph_.states().size());
    const bool waits = first_ >= needed && count <= kLongestWait * options_.states;
    return count > options_.states && !waits;
  };
  while (too_many()) {
    drop_first_state(graph_.data(), marginalize_first_state(graph_.data(), graph_.options()));
    ++first_;
  }
  return report;
}

}  // namespace imslam::pgo

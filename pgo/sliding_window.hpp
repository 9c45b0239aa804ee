#pragma once

#include "pgo/pose_velocity_graph.hpp"

namespace imslam::pgo {

struct WindowOptions {
  int states = 20;         ///< kept for optimisation; older ones become a linear prior
  int max_iterations = 5;  ///< per frame
  double function_tolerance = 1e-6;
  /// In place of GraphOptions::kernel_width: while velocity and biases become known, motions that
  /// are right look wrong by more than later, and what leaves the window is not weighed again.
  double kernel_width = 4.0;

  void describe(Config& config);
  void validate() const;
};

/// Fixed-lag smoother for streaming: the pose-velocity graph over the newest states; the oldest is
/// marginalised into a linear prior on its neighbours and the globals (see marginalization.hpp).
/// The time per frame depends on the window, not on the length of the sequence.
///
/// States keep the number they had when they were added; numbers only grow.
class SlidingWindow {
 public:
  /// Takes over a graph, e.g. one that initialisation has solved, as frames 0, 1, ...
  SlidingWindow(PoseVelocityGraph graph, const WindowOptions& options);

  int add_state(const State& guess);

  /// False: the measurement cannot be used, or one of its states has left the window.
  bool add_visual_edge(int from, int to, const RelativeMotion& motion);
  bool add_imu_edge(int from, int to, const ImuMotion& motion);
  bool add_zero_velocity(int state, double sigma = 0.01);

  /// Optimises the window, then marginalises what exceeds it. State `needed` and younger ones stay
  /// as long as no more than kLongestWait windows are full: a measurement that begins there is to
  /// come.
  SolveReport update(int needed);
  SolveReport update() { return update(end()); }

  int first() const { return first_; }  ///< number of the oldest state in the window
  int end() const { return first_ + static_cast<int>(graph_.states().size()); }
  const State& state(int number) const;
  const State& newest() const { return graph_.states().back(); }
  const Globals& globals() const { return graph_.globals(); }
  const PoseVelocityGraph& graph() const { return graph_; }  ///< states first() to end()

 private:
  bool inside(int number) const { return number >= first_ && number < end(); }

  PoseVelocityGraph graph_;
  WindowOptions options_;
  static constexpr int kLongestWait = 3;

  int first_ = 0;
};

}  // namespace imslam::pgo

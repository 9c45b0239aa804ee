#pragma once

#include <vector>

#include "pgo/graph_data.hpp"
#include "pgo/options.hpp"
#include "slam/base/solve_report.hpp"

namespace imslam::pgo {

/// Weights of the published method; the information of a family is weight^2 I.
struct PaperWeights {
  double visual = 1.0;
  double velocity_step = 0.1;
  double rotation_step = 10.0;
  double translation_velocity = 0.1;

  static PaperWeights kitti() { return {1.0, 0.1, 10.0, 0.1}; }
  static PaperWeights euroc() { return {4.0, 0.1, 2.0, 0.1}; }
};

struct PaperOptions {
  std::string dataset = "euroc";  ///< whose weights: euroc or kitti
  int window_steps = 8;
  double gravity_magnitude = 9.81;  ///< [m/s^2]

  PaperWeights weights() const;
  void describe(Config& config);
  void validate() const;
};

struct PaperResult {
  std::vector<State> states;         ///< one more than motions; the first as given
  std::vector<SolveReport> reports;  ///< one per window
};

/// The published graph, to reproduce and to compare with: windows of `window_steps` motions, each
/// solved on its own from the last state of the one before it, which is held. Per step
///
///   r_vo  = Log(P^-1 T_i^-1 T_j)             r_dv = dv_world - (v_j - v_i)
///   r_rot = Log(dR^-1 R_i^-1 R_j)            r_tv = (p_j - p_i) - (v_i dt + dp_world)
///
/// dv_world, dp_world: the IMU motion turned into the world by the attitude that the window's IMU
/// rotations predict, gravity added. No covariances, biases (beyond those subtracted already),
/// gravity state or robust kernel. Motions that are not valid contribute nothing; a step without
/// any is bridged by constant velocity. Source: slam.md, section 2.
PaperResult solve_paper_windows(const State& first,
                                const std::vector<RelativeMotion>& visual,
                                const std::vector<ImuMotion>& inertial,
                                const PaperOptions& options,
                                const SolverOptions& solver = {});

}  // namespace imslam::pgo

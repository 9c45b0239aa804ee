#pragma once

#include "pgo/options.hpp"
#include "slam/base/solve_report.hpp"
#include "slam/training/inertial_methods.hpp"

namespace imslam::training {

/// The graph of a run with vision as good as stereo odometry's best.
struct GraphBiasOptions {
  double interval_s = 0.05;          ///< [s] between states
  double vision_rotation = 2.5e-4;   ///< [rad] standard deviation of a visual motion, per axis
  double vision_translation = 1e-3;  ///< [m] likewise
  double gyro_noise_factor = 2.0;    ///< [1] on the datasheet's density, as a run has it
  double accel_noise_factor = 8.0;   ///< [1] likewise
  int relinearisations = 4;          ///< integrations at the biases found, at most
  pgo::SolverOptions solver;
};

struct GraphBias {
  std::vector<StampedBias> biases;                ///< one per state
  std::vector<imu::StampedBiasSigma> bias_sigma;  ///< alike; empty: the graph does not determine it
  SolveReport report;
};

/// Biases of the pose-velocity graph over a whole log whose visual edges are the truth's relative
/// poses. It sees the future and the truth: what is left of the errors when the bias is as well
/// known as vision can tell.
GraphBias estimate_graph_bias(const InertialLog& log, const GraphBiasOptions& options = {});

/// Each window gets the bias at its start, as sure as the graph says.
InertialMethod graph_bias_method(const GraphBiasOptions& options = {});

}  // namespace imslam::training

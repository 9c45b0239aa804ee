#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "imu_net/imu_network.hpp"
#include "imu_net/preintegration.hpp"

namespace imslam::imu {

/// An upper cost of one integrated motion as a function of its covariance, and its slope:
/// dU = trace(by_covariance^T dSigma).
struct CovarianceSlope {
  double cost = 0.0;
  Eigen::Matrix<double, 9, 9> by_covariance;
};

/// The short edges of a graph and how its front end integrates them.
struct EdgeNoiseTask {
  struct Edge {
    std::int64_t time0_ns = 0;
    std::int64_t time1_ns = 0;
    ImuBias bias;
    double time_offset_s = 0.0;
    std::function<CovarianceSlope(const ImuMotion&)> cost;
  };
  const std::vector<ImuSample>* samples = nullptr;
  ImuNoise datasheet;                     ///< that the network's ratios refer to
  ImuNoise base;                          ///< of the graph's own; the network's is added to it
  std::vector<std::int64_t> frame_times;  ///< of the frames that the answer belongs to
  std::vector<Edge> edges;
  PreintegrationOptions options;
};

/// Mean of U over the edges, through what the answer's edge_noise adds to the readings' variances;
/// backward exactly. Edges that cannot be integrated do not count.
template <typename S>
nn::Var edge_noise_cost(nn::Tape<S>& tape, const ImuAnswer& answer, const EdgeNoiseTask& task);

}  // namespace imslam::imu

#pragma once

#include "pgo/graph_data.hpp"
#include "pgo/imu_factor.hpp"
#include "pgo/relative_pose_factor.hpp"

namespace imslam::pgo {

/// Whitened residual of an edge at the graph's states, and its derivatives, that by the measurement
/// included.
RelativePoseFactor::Linearization linearize(const VisualEdge& edge, const GraphData& data);
ImuFactor::Linearization linearize(const InertialEdge& edge,
                                   const GraphData& data,
                                   double gravity_magnitude);

}  // namespace imslam::pgo

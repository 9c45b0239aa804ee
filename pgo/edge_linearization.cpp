#include "pgo/edge_linearization.hpp"

namespace imslam::pgo {
namespace {

const State& state_at(const GraphData& data, int state) {
  return data.states[static_cast<std::size_t>(state)];
}

}  // namespace

RelativePoseFactor::Linearization linearize(const VisualEdge& edge, const GraphData& data) {
  const Globals& globals = data.globals;
  return RelativePoseFactor(edge.motion, edge.sqrt_information, data.T_body_left)
      .linearize(state_at(data, edge.from).nav.T_world_body,
                 state_at(data, edge.to).nav.T_world_body,
                 {globals.disparity_offset, globals.focal_error, globals.camera_rotation});
}

ImuFactor::Linearization linearize(const InertialEdge& edge,
                                   const GraphData& data,
                                   double gravity_magnitude) {
  const State& from = state_at(data, edge.from);
  const State& to = state_at(data, edge.to);
  ImuFactor::Point point{from.nav.T_world_body,
                         from.nav.v_world,
                         to.nav.T_world_body,
                         to.nav.v_world,
                         {},
                         data.globals.gravity_direction,
                         data.globals.time_offset_s,
                         data.globals.gyro_shape};
  point.bias << from.bias.gyro, from.bias.accel;
  return ImuFactor(edge.motion, edge.sqrt_information, gravity_magnitude).linearize(point);
}

}  // namespace imslam::pgo

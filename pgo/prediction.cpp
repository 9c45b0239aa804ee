#include "pgo/prediction.hpp"

#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::pgo {

State predict(const State& from,
              const ImuMotion& motion,
              const Eigen::Vector3d& gravity,
              double time_offset_s) {
  const double dt = motion.dt_s;
  Eigen::Matrix<double, 6, 1> db;
  db << from.bias.gyro - motion.bias.gyro, from.bias.accel - motion.bias.accel;
  const Eigen::Matrix<double, 9, 1> shift =
      motion.J_time_offset * (time_offset_s - motion.time_offset_s);
  const lie::SO3d dR = motion.dR * lie::SO3d::exp(motion.J_dR_bias * db + shift.head<3>());
  const Eigen::Vector3d dv = motion.dv + motion.J_dv_bias * db + shift.segment<3>(3);
  const Eigen::Vector3d dp = motion.dp + motion.J_dp_bias * db + shift.tail<3>();

  const lie::SO3d& R = from.nav.T_world_body.rotation();
  State to = from;
  to.time_ns = motion.time1_ns;
  to.nav.v_world = from.nav.v_world + gravity * dt + R * dv;
  to.nav.T_world_body =
      lie::SE3d(R * dR, from.nav.T_world_body.translation() + from.nav.v_world * dt +
                            gravity * (0.5 * dt * dt) + R * dp);
  return to;
}

State predict(const State& from, const RelativeMotion& motion) {
  const double dt = to_seconds(motion.time1_ns - motion.time0_ns);
  expects(dt > 0.0, "prediction: a motion takes time");
  State to = from;
  to.time_ns = motion.time1_ns;
  to.nav.T_world_body = from.nav.T_world_body * motion.T_body0_body1;
  to.nav.v_world = from.nav.T_world_body.rotation() * motion.T_body0_body1.translation() / dt;
  return to;
}

std::vector<State> chain_states(const State& first, const std::vector<RelativeMotion>& motions) {
  std::vector<State> states = {first};
  lie::SE3d::Tangent rate = lie::SE3d::Tangent::Zero();  // [m/s, rad/s] in the body
  for (const RelativeMotion& motion : motions) {
    const double dt = to_seconds(motion.time1_ns - motion.time0_ns);
    RelativeMotion step = motion;
    if (motion.valid) {
      rate = motion.T_body0_body1.log() / dt;
    } else {
      step.T_body0_body1 = lie::SE3d::exp(rate * dt);
    }
    states.push_back(predict(states.back(), step));
  }
  if (states.size() >= 2) states[0].nav.v_world = states[1].nav.v_world;
  return states;
}

}  // namespace imslam::pgo

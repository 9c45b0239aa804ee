#include "pgo/pose_velocity_graph.hpp"

#include <cmath>
#include <numeric>

#include "pgo/graph_problem.hpp"
#include "pgo/whitening.hpp"
#include "slam/base/error.hpp"

namespace imslam::pgo {
namespace {

// The gauge has no cost: these only need to be stiff beside the measurements (1e-5 m over one
// interval of a good IMU) without spoiling the condition of the normal equations.
constexpr double kAnchorSigmaPosition_m = 1e-5;
constexpr double kAnchorSigmaAngle_rad = 1e-5;

bool finite(const lie::SE3d& pose) {
  return pose.translation().allFinite() && pose.rotation().quaternion().coeffs().allFinite();
}

bool finite(const RelativeMotion& motion) {
  return finite(motion.T_body0_body1) && motion.J_disparity_offset.allFinite() &&
         motion.J_focal_error.allFinite() && std::isfinite(motion.disparity_offset);
}

bool finite(const ImuMotion& motion) {
  return std::isfinite(motion.dt_s) && motion.dt_s > 0.0 &&
         motion.dR.quaternion().coeffs().allFinite() && motion.dv.allFinite() &&
         motion.dp.allFinite() && motion.bias.gyro.allFinite() && motion.bias.accel.allFinite() &&
         motion.J_dR_bias.allFinite() && motion.J_dv_bias.allFinite() &&
         motion.J_dp_bias.allFinite() && motion.J_time_offset.allFinite() &&
         std::isfinite(motion.time_offset_s);
}

/// Which states hang together; the representative of a set is found by following parents.
class Components {
 public:
  explicit Components(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int find(int i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      int& parent = parent_[static_cast<std::size_t>(i)];
      parent = parent_[static_cast<std::size_t>(parent)];
      i = parent;
    }
    return i;
  }
  void join(int a, int b) { parent_[static_cast<std::size_t>(find(a))] = find(b); }

 private:
  std::vector<int> parent_;
};

}  // namespace

std::string unsolvable_reason(const GraphData& data) {
  if (data.states.empty()) return "the graph has no states";
  Components components(data.states.size());
  for (const VisualEdge& edge : data.visual_edges) components.join(edge.from, edge.to);
  for (const InertialEdge& edge : data.inertial_edges) components.join(edge.from, edge.to);

  std::vector<bool> held(data.states.size(), false);
  const auto hold = [&](int state) {
    held[static_cast<std::size_t>(components.find(state))] = true;
  };
  for (const PosePrior& prior : data.pose_priors) hold(prior.state);
  for (const Anchor& anchor : data.anchors) hold(anchor.state);
  for (const BlockId& id : data.marginal.blocks) {
    if (id.kind == BlockId::Kind::kPose) hold(id.state);
  }
  for (std::size_t i = 0; i < data.states.size(); ++i) {
    if (!held[static_cast<std::size_t>(components.find(static_cast<int>(i)))]) {
      return "state " + std::to_string(i) + " is not connected to any anchored pose";
    }
  }
  return "";
}

PoseVelocityGraph::PoseVelocityGraph(const GraphOptions& options) : options_(options) {
  options.validate();
}

void PoseVelocityGraph::expect_state(int state) const {
  expects(state >= 0 && static_cast<std::size_t>(state) < data_.states.size(),
          "graph: no such state");
}

int PoseVelocityGraph::add_state(const State& guess) {
  expects(data_.states.empty() || guess.time_ns > data_.states.back().time_ns,
          "graph: stamps of states must increase");
  data_.states.emplace_back();
  data_.states.back().time_ns = guess.time_ns;
  const int index = static_cast<int>(data_.states.size()) - 1;
  set_state(index, guess);
  return index;
}

void PoseVelocityGraph::set_state(int state, const State& value) {
  expect_state(state);
  expects(finite(value.nav.T_world_body) && value.nav.v_world.allFinite() &&
              value.bias.gyro.allFinite() && value.bias.accel.allFinite(),
          "graph: a state must be finite");
  State& target = data_.states[static_cast<std::size_t>(state)];
  expects(value.time_ns == target.time_ns, "graph: the stamp of a state is fixed");
  target = value;
}

void PoseVelocityGraph::set_globals(const Globals& globals) {
  expects(globals.gravity_direction.allFinite() && globals.gravity_direction.norm() > 1e-6 &&
              std::isfinite(globals.disparity_offset) && std::isfinite(globals.focal_error) &&
              std::isfinite(globals.time_offset_s) && globals.camera_rotation.allFinite() &&
              globals.gyro_shape.allFinite(),
          "graph: globals must be finite");
  data_.globals = globals;
  data_.globals.gravity_direction.normalize();
}

void PoseVelocityGraph::set_camera(const lie::SE3d& T_body_left) {
  expects(finite(T_body_left), "graph: the camera's pose must be finite");
  data_.T_body_left = T_body_left;
}

bool PoseVelocityGraph::add_visual_edge(int from, int to, const RelativeMotion& motion) {
  expect_state(from);
  expect_state(to);
  expects(from != to, "graph: a visual edge joins two states");
  const auto W = sqrt_information(motion.covariance);
  if (!W || !finite(motion)) return false;
  data_.visual_edges.push_back({from, to, motion, *W});
  return true;
}

bool PoseVelocityGraph::add_imu_edge(int from, int to, const ImuMotion& motion) {
  expect_state(from);
  expect_state(to);
  expects(from < to, "graph: an IMU edge leads forward in time");
  const auto W = sqrt_information(motion.covariance);
  if (!W || !finite(motion)) return false;
  data_.inertial_edges.push_back({from, to, motion, *W});
  return true;
}

bool PoseVelocityGraph::set_visual_motion(std::size_t edge, const RelativeMotion& motion) {
  expects(edge < data_.visual_edges.size(), "graph: no such visual edge");
  const auto W = sqrt_information(motion.covariance);
  if (!W || !finite(motion)) return false;
  data_.visual_edges[edge].motion = motion;
  data_.visual_edges[edge].sqrt_information = *W;
  return true;
}

bool PoseVelocityGraph::set_imu_motion(std::size_t edge, const ImuMotion& motion) {
  expects(edge < data_.inertial_edges.size(), "graph: no such IMU edge");
  const auto W = sqrt_information(motion.covariance);
  if (!W || !finite(motion)) return false;
  data_.inertial_edges[edge].motion = motion;
  data_.inertial_edges[edge].sqrt_information = *W;
  return true;
}

void PoseVelocityGraph::anchor_pose(int state, const lie::SE3d& T_world_body) {
  Eigen::Matrix<double, 6, 1> variance;
  variance << Eigen::Vector3d::Constant(std::pow(kAnchorSigmaPosition_m, 2)),
      Eigen::Vector3d::Constant(std::pow(kAnchorSigmaAngle_rad, 2));
  expects(add_pose_prior(state, T_world_body, variance.asDiagonal()),
          "graph: an anchor must be finite");
}

void PoseVelocityGraph::anchor_position_and_heading(int state, const lie::SE3d& T_world_body) {
  expect_state(state);
  expects(finite(T_world_body), "graph: an anchor must be finite");
  data_.anchors.push_back({state, T_world_body, kAnchorSigmaPosition_m, kAnchorSigmaAngle_rad});
}

bool PoseVelocityGraph::add_pose_prior(int state,
                                       const lie::SE3d& T_world_body,
                                       const Eigen::Matrix<double, 6, 6>& covariance) {
  expect_state(state);
  const auto W = sqrt_information(covariance);
  if (!W || !finite(T_world_body)) return false;
  data_.pose_priors.push_back({state, T_world_body, *W});
  return true;
}

void PoseVelocityGraph::add_velocity_prior(int state,
                                           const Eigen::Vector3d& v_world,
                                           double sigma) {
  expect_state(state);
  expects(v_world.allFinite() && sigma > 0.0, "graph: a velocity prior needs a positive sigma");
  data_.velocity_priors.push_back({state, v_world, sigma});
}

void PoseVelocityGraph::add_zero_velocity(int state, double sigma) {
  add_velocity_prior(state, Eigen::Vector3d::Zero(), sigma);
}

void PoseVelocityGraph::add_bias_prior(int state,
                                       const ImuBias& bias,
                                       double sigma_gyro,
                                       double sigma_accel) {
  add_bias_prior(
      state, bias,
      ImuBias{Eigen::Vector3d::Constant(sigma_gyro), Eigen::Vector3d::Constant(sigma_accel)});
}

void PoseVelocityGraph::add_bias_prior(int state, const ImuBias& bias, const ImuBias& sigma) {
  expect_state(state);
  expects(bias.gyro.allFinite() && bias.accel.allFinite() && sigma.gyro.minCoeff() > 0.0 &&
              sigma.accel.minCoeff() > 0.0,
          "graph: a bias prior needs positive sigmas");
  data_.bias_priors.push_back({state, bias, sigma});
}

void PoseVelocityGraph::add_gravity_prior(const Eigen::Vector3d& direction, double sigma_rad) {
  expects(direction.allFinite() && direction.norm() > 1e-6 && sigma_rad > 0.0,
          "graph: a gravity prior needs a direction and a positive sigma");
  data_.gravity_priors.push_back({direction.normalized(), sigma_rad});
}

void PoseVelocityGraph::add_disparity_offset_prior(double value_px, double sigma_px) {
  expects(std::isfinite(value_px) && sigma_px > 0.0, "graph: a prior needs a positive sigma");
  data_.disparity_offset_priors.push_back({value_px, sigma_px});
}

void PoseVelocityGraph::add_focal_error_prior(double value, double sigma) {
  expects(std::isfinite(value) && sigma > 0.0, "graph: a prior needs a positive sigma");
  data_.focal_error_priors.push_back({value, sigma});
}

void PoseVelocityGraph::add_time_offset_prior(double value_s, double sigma_s) {
  expects(std::isfinite(value_s) && sigma_s > 0.0, "graph: a prior needs a positive sigma");
  data_.time_offset_priors.push_back({value_s, sigma_s});
}

void PoseVelocityGraph::add_camera_rotation_prior(const Eigen::Vector3d& value_rad,
                                                  double sigma_rad) {
  expects(value_rad.allFinite() && sigma_rad > 0.0, "graph: a prior needs a positive sigma");
  data_.camera_rotation_priors.push_back({value_rad, sigma_rad});
}

void PoseVelocityGraph::add_gyro_shape_prior(const Eigen::Matrix3d& value, double sigma) {
  expects(value.allFinite() && sigma > 0.0, "graph: a prior needs a positive sigma");
  data_.gyro_shape_priors.push_back({value, sigma});
}

}  // namespace imslam::pgo

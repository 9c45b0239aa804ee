#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pgo/graph_data.hpp"
#include "pgo/options.hpp"
#include "slam/base/solve_report.hpp"

namespace imslam::pgo {

/// Covariance of one state, tangent [rho theta nu gyro accel].
using StateCovariance = Eigen::Matrix<double, 15, 15>;

/// Standard deviations of what is estimated once for the whole graph, all else being unknown too.
/// Empty: held, or in no factor.
struct GlobalSigmas {
  std::optional<double> disparity_offset;          ///< [px]
  std::optional<double> focal_error;               ///< [1]
  std::optional<double> time_offset_s;             ///< [s]
  std::optional<Eigen::Vector3d> camera_rotation;  ///< [rad]
  std::optional<Eigen::Matrix3d> gyro_shape;       ///< [1]
};

/// How sure the solution is: entries of the inverse of J^T J there. True where the factors'
/// covariances are; robust kernels count as their weights.
struct GraphUncertainty {
  std::vector<StateCovariance> states;
  GlobalSigmas globals;
};

/// The pose-velocity graph: per frame a pose, a velocity and an IMU bias; globally the direction of
/// gravity, the disparity offset, the error of the focal length, and between camera and IMU the
/// time offset and the error of the stated rotation, and the scale and axes of the gyro.
///
///   solve() moves the states to   argmin  1/2 sum rho(|r_visual|^2) + 1/2 sum |r_other|^2
///
/// Without inertial edges it is a pose graph: velocities and biases are then left as they are.
/// Whatever goes in, the states stay finite: measurements that are not finite or whose covariance
/// is not positive are refused (add_* returns false).
class PoseVelocityGraph {
 public:
  explicit PoseVelocityGraph(const GraphOptions& options = {});

  /// Appends a state with its first guess and returns its index. Stamps must increase.
  int add_state(const State& guess);

  /// Edges refer to existing states; visual ones may also close loops. False: the measurement
  /// cannot be used.
  bool add_visual_edge(int from, int to, const RelativeMotion& motion);
  bool add_imu_edge(int from, int to, const ImuMotion& motion);

  /// Replaces the measurement of an edge, e.g. after the network that made it has learned. False:
  /// it cannot be used and the old one stays.
  bool set_visual_motion(std::size_t edge, const RelativeMotion& motion);
  bool set_imu_motion(std::size_t edge, const ImuMotion& motion);

  /// Fixes the gauge: all 6 dof of a pose (no IMU, or gravity estimated) ...
  void anchor_pose(int state, const lie::SE3d& T_world_body);
  /// ... or position and heading only (IMU and known direction of gravity).
  void anchor_position_and_heading(int state, const lie::SE3d& T_world_body);

  bool add_pose_prior(int state,
                      const lie::SE3d& T_world_body,
                      const Eigen::Matrix<double, 6, 6>& covariance);
  void add_velocity_prior(int state, const Eigen::Vector3d& v_world, double sigma);
  /// The body stood still at `state`; sigma [m/s].
  void add_zero_velocity(int state, double sigma = 0.01);
  void add_bias_prior(int state, const ImuBias& bias, double sigma_gyro, double sigma_accel);
  void add_bias_prior(int state, const ImuBias& bias, const ImuBias& sigma);  ///< axis by axis
  void add_gravity_prior(const Eigen::Vector3d& direction, double sigma_rad);
  void add_disparity_offset_prior(double value_px, double sigma_px);
  void add_focal_error_prior(double value, double sigma);
  void add_time_offset_prior(double value_s, double sigma_s);
  void add_camera_rotation_prior(const Eigen::Vector3d& value_rad, double sigma_rad);
  void add_gyro_shape_prior(const Eigen::Matrix3d& value, double sigma);

  /// Never throws for numerical reasons; `reason` says what is wrong with an unsolvable graph.
  SolveReport solve(const SolverOptions& options = {});

  /// Cost at the present states, as solve() defines it.
  double cost() const;

  /// Joint covariance of one state, tangent [rho theta nu gyro accel]. Empty Optional: the graph
  /// does not determine the states (no anchor, disconnected). Rows and columns of unknowns that the
  /// graph does not estimate are zero.
  std::optional<std::vector<StateCovariance>> covariances() const;
  std::optional<StateCovariance> covariance(int state) const;
  /// The same of all states, and the globals' standard deviations, from one factorisation.
  std::optional<GraphUncertainty> uncertainty() const;

  const std::vector<State>& states() const { return data_.states; }
  const Globals& globals() const { return data_.globals; }
  const std::vector<VisualEdge>& visual_edges() const { return data_.visual_edges; }
  const std::vector<InertialEdge>& inertial_edges() const { return data_.inertial_edges; }
  const GraphOptions& options() const { return options_; }

  void set_state(int state, const State& value);
  void set_globals(const Globals& globals);
  /// Where the camera that the visual edges are of sits in the body, as stated: needed if its
  /// rotation is estimated.
  void set_camera(const lie::SE3d& T_body_left);

  /// The whole graph as plain data, for the other files of this room and for inspection.
  const GraphData& data() const { return data_; }
  GraphData& data() { return data_; }

 private:
  void expect_state(int state) const;

  GraphOptions options_;
  GraphData data_;
};

/// Why `data` cannot be solved: no anchor, or states without connection to it. Empty: it can.
std::string unsolvable_reason(const GraphData& data);

}  // namespace imslam::pgo

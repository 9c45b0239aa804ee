#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "slam/lie/nav_state.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam::pgo {

/// What is estimated at one frame.
struct State {
  std::int64_t time_ns = 0;
  lie::NavState nav;
  ImuBias bias;
};

/// What is estimated once for the whole graph (or held, see GraphOptions).
struct Globals {
  Eigen::Vector3d gravity_direction = -Eigen::Vector3d::UnitZ();  ///< in world, unit vector
  double disparity_offset = 0.0;                                  ///< [px]
  double focal_error = 0.0;    ///< [1], true focal length = (1 + focal_error) stated
  double time_offset_s = 0.0;  ///< [s], t_imu = t_camera + time_offset
  /// [rad], true R_body_left = stated Exp(camera_rotation).
  Eigen::Vector3d camera_rotation = Eigen::Vector3d::Zero();
  /// [1] scale errors and axes askew: reading = (I + gyro_shape) true rate + bias.
  Eigen::Matrix3d gyro_shape = Eigen::Matrix3d::Zero();
};

/// A motion that vision measured between two states, consecutive or not.
struct VisualEdge {
  int from = 0;
  int to = 0;
  RelativeMotion motion;
  Eigen::Matrix<double, 6, 6> sqrt_information;  ///< lower triangular
};

/// A motion that the IMU measured between two states.
struct InertialEdge {
  int from = 0;
  int to = 0;
  ImuMotion motion;
  Eigen::Matrix<double, 9, 9> sqrt_information;  ///< lower triangular
};

struct PosePrior {
  int state = 0;
  lie::SE3d T_world_body;
  Eigen::Matrix<double, 6, 6> sqrt_information;  ///< lower triangular
};

/// Position and heading of one pose: the 4-dof gauge of a graph with gravity.
struct Anchor {
  int state = 0;
  lie::SE3d T_world_body;
  double sigma_position_m = 0.0;
  double sigma_yaw_rad = 0.0;
};

struct VelocityPrior {
  int state = 0;
  Eigen::Vector3d v_world;
  double sigma = 0.0;  ///< [m/s]
};

struct BiasPrior {
  int state = 0;
  ImuBias bias;
  ImuBias sigma;  ///< axis by axis
};

struct GravityPrior {
  Eigen::Vector3d direction;
  double sigma = 0.0;  ///< [rad]
};

struct ScalarPrior {
  double value = 0.0;
  double sigma = 0.0;
};

struct RotationPrior {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();  ///< [rad]
  double sigma = 0.0;                               ///< [rad]
};

struct ShapePrior {
  Eigen::Matrix3d value = Eigen::Matrix3d::Zero();  ///< [1]
  double sigma = 0.0;                               ///< [1] of each entry
};

/// Names one parameter block of the graph. `state` is ignored for the global ones.
struct BlockId {
  enum class Kind {
    kPose,
    kVelocity,
    kBias,
    kGravity,
    kDisparityOffset,
    kFocalError,
    kTimeOffset,
    kCameraRotation,
    kGyroShape
  };
  Kind kind = Kind::kPose;
  int state = 0;

  bool global() const { return kind >= Kind::kGravity; }
  friend bool operator==(const BlockId& a, const BlockId& b) {
    return a.kind == b.kind && (a.global() || a.state == b.state);
  }
};

/// What marginalised states still say about the remaining ones: a linear prior
///
///   r = residual + J [x_0 minus X_0, x_1 minus X_1, ...]
///
/// around the point X where it was linearised ("first estimates"); minus is that of each block's
/// manifold and the columns of J follow `blocks`.
struct MarginalPrior {
  std::vector<BlockId> blocks;
  std::vector<Eigen::VectorXd> point;  ///< X: the numbers of each block, as in the parameter block
  Eigen::MatrixXd J;
  Eigen::VectorXd residual;

  bool empty() const { return blocks.empty(); }
};

/// The graph as plain data.
struct GraphData {
  std::vector<State> states;
  Globals globals;
  lie::SE3d T_body_left;  ///< as stated; matters to globals.camera_rotation alone

  std::vector<VisualEdge> visual_edges;
  std::vector<InertialEdge> inertial_edges;
  std::vector<PosePrior> pose_priors;
  std::vector<Anchor> anchors;
  std::vector<VelocityPrior> velocity_priors;
  std::vector<BiasPrior> bias_priors;
  std::vector<GravityPrior> gravity_priors;
  std::vector<ScalarPrior> disparity_offset_priors;
  std::vector<ScalarPrior> focal_error_priors;
  std::vector<ScalarPrior> time_offset_priors;
  std::vector<RotationPrior> camera_rotation_priors;
  std::vector<ShapePrior> gyro_shape_priors;
  MarginalPrior marginal;
};

}  // namespace imslam::pgo

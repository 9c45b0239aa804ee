#pragma once

#include <Eigen/Core>
#include <vector>

#include "imu_net/midpoint_step.hpp"
#include "imu_net/symmetric_blocks.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam::imu {

/// The inertial signal at one instant, and how all of it changes per second of time offset.
struct SignalNode {
  double time_s = 0.0;                                      ///< [s] since a common origin, IMU time
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();           ///< [rad/s]
  Eigen::Vector3d force = Eigen::Vector3d::Zero();          ///< [m/s^2]
  Eigen::Vector3d gyro_variance = Eigen::Vector3d::Zero();  ///< on top of the datasheet's, see
  Eigen::Vector3d accel_variance = Eigen::Vector3d::Zero();  ///< ImuSample

  double time_slope = 0.0;                                ///< 1 at the ends, 0 at samples
  Eigen::Vector3d rate_slope = Eigen::Vector3d::Zero();   ///< [rad/s^2]
  Eigen::Vector3d force_slope = Eigen::Vector3d::Zero();  ///< [m/s^3]
};

/// The point a fraction of the way from a to b, linearly.
SignalNode between(const SignalNode& a, const SignalNode& b, double fraction);

/// Standard deviation of what a stretch without samples may hide. The unknown error is a constant
/// plus a ramp from one end to the other, each that strong: together they reach velocity and
/// position independently.
struct GapSpread {
  double rate = 0.0;   ///< [rad/s]
  double force = 0.0;  ///< [m/s^2]
};

/// A step as it was taken.
struct RecordedStep {
  MidpointStep step;
  Eigen::Matrix<double, 9, 3> A_Sigma_R;  ///< see MidpointStep::carry_covariance()
  double middle_s = 0.0;                  ///< [s] of its middle, as in SignalNode
};

/// Sums the signal up, step by step, with covariance and derivatives.
class MidpointIntegrator {
 public:
  /// Every step is appended to `record`, too, if there is one.
  MidpointIntegrator(const ImuBias& bias,
                     const ImuNoise& noise,
                     std::vector<RecordedStep>* record = nullptr);

  /// One stretch from a to b, linear in between; cut into steps no longer than max_step_s.
  void add(const SignalNode& a, const SignalNode& b, double max_step_s);

  /// The same for a stretch that was not seen: the covariance also gets `spread`.
  void add_gap(const SignalNode& a,
               const SignalNode& b,
               double max_step_s,
               const GapSpread& spread);

  /// dR, dv, dp, covariance and Jacobians so far; times are not set.
  ImuMotion motion() const;

 private:
  void add_steps(const SignalNode& a, const SignalNode& b, int steps);
  void step(const SignalNode& a, const SignalNode& b);
  void carry_bias(const MidpointStep& step);
  void carry_time_offset(const MidpointStep& step, const SignalNode& a, const SignalNode& b);
  void carry_gap(const MidpointStep& step);

  ImuBias bias_;
  double gyro_density_sq_;
  double accel_density_sq_;
  std::vector<RecordedStep>* record_;
  lie::SO3d dR_;
  Eigen::Vector3d dv_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d dp_ = Eigen::Vector3d::Zero();
  SymmetricBlocks covariance_;
  Eigen::Matrix<double, 9, 3> J_gyro_bias_ = Eigen::Matrix<double, 9, 3>::Zero();
  Eigen::Matrix<double, 6, 3> J_accel_bias_ = Eigen::Matrix<double, 6, 3>::Zero();  ///< [dv dp]
  Eigen::Matrix<double, 9, 1> J_time_offset_ = Eigen::Matrix<double, 9, 1>::Zero();
  bool in_gap_ = false;
  double ramp_ = 0.0;                       ///< value of the gap's ramp in the present step
  Eigen::Matrix<double, 9, 6> J_gap_;       ///< w.r.t. a constant error [rate force]
  Eigen::Matrix<double, 9, 6> J_gap_ramp_;  ///< w.r.t. the strength of a ramp
};

}  // namespace imslam::imu

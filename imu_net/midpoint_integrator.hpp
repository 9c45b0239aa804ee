#pragma once

#include <Eigen/Core>

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

/// Sums the signal up, step by step, with covariance and derivatives.
class MidpointIntegrator {
 public:
  MidpointIntegrator(const ImuBias& bias, const ImuNoise& noise) : bias_(bias), noise_(noise) {}

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
  /// Derivatives of one step: x' = A x + B_rate d_rate + B_force d_force + b_length d_length, for
  /// x = [dR dv dp] and A = [A_R 0 0; A_v I 0; A_p h I].
  struct StepDerivative {
    double h = 0.0;
    Eigen::Matrix3d A_R, A_v, A_p;
    Eigen::Matrix<double, 9, 3> B_rate, B_force;
    Eigen::Matrix<double, 9, 1> b_length;

    template <int Columns>
    void carry(Eigen::Matrix<double, 9, Columns>& X) const;
  };

  void add_steps(const SignalNode& a, const SignalNode& b, int steps);
  void step(const SignalNode& a, const SignalNode& b);
  void advance_derivatives(const StepDerivative& d, const SignalNode& a, const SignalNode& b);

  /// White noise per axis on the mean reading of the step, on top of the datasheet's.
  void add_variance(const StepDerivative& d,
                    const Eigen::Vector3d& gyro,
                    const Eigen::Vector3d& accel);

  ImuBias bias_;
  ImuNoise noise_;
  lie::SO3d dR_;
  Eigen::Vector3d dv_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d dp_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 9, 9> covariance_ = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 6> J_bias_ = Eigen::Matrix<double, 9, 6>::Zero();
  Eigen::Matrix<double, 9, 1> J_time_offset_ = Eigen::Matrix<double, 9, 1>::Zero();
  bool in_gap_ = false;
  double ramp_ = 0.0;                       ///< value of the gap's ramp in the present step
  Eigen::Matrix<double, 9, 6> J_gap_;       ///< w.r.t. a constant error [rate force]
  Eigen::Matrix<double, 9, 6> J_gap_ramp_;  ///< w.r.t. the strength of a ramp
};

}  // namespace imslam::imu

#include "imu_net/midpoint_integrator.hpp"

#include <algorithm>
#include <cmath>

namespace imslam::imu {

using lie::skew;
using lie::SO3d;

namespace {

constexpr int kGapSteps = 4;  ///< enough to tell a ramp from a constant

int step_count(const SignalNode& a, const SignalNode& b, double max_step_s) {
  const double steps = std::ceil((b.time_s - a.time_s) / max_step_s - 1e-9);
  return std::max(1, static_cast<int>(steps));
}

}  // namespace

SignalNode between(const SignalNode& a, const SignalNode& b, double fraction) {
  const auto mix = [fraction](const auto& x, const auto& y) { return x + fraction * (y - x); };
  SignalNode node;
  node.time_s = mix(a.time_s, b.time_s);
  node.rate = mix(a.rate, b.rate);
  node.force = mix(a.force, b.force);
  node.gyro_variance = mix(a.gyro_variance, b.gyro_variance);
  node.accel_variance = mix(a.accel_variance, b.accel_variance);
  node.time_slope = mix(a.time_slope, b.time_slope);
  node.rate_slope = mix(a.rate_slope, b.rate_slope);
  node.force_slope = mix(a.force_slope, b.force_slope);
  return node;
}

void MidpointIntegrator::add(const SignalNode& a, const SignalNode& b, double max_step_s) {
  add_steps(a, b, step_count(a, b, max_step_s));
}

void MidpointIntegrator::add_gap(const SignalNode& a,
                                 const SignalNode& b,
                                 double max_step_s,
                                 const GapSpread& spread) {
  in_gap_ = true;
  J_gap_.setZero();
  J_gap_ramp_.setZero();
  add_steps(a, b, std::max(kGapSteps, step_count(a, b, max_step_s)));
  in_gap_ = false;
  Eigen::Matrix<double, 6, 1> variance;
  variance << Eigen::Vector3d::Constant(spread.rate * spread.rate),
      Eigen::Vector3d::Constant(spread.force * spread.force);
  covariance_ += J_gap_ * variance.asDiagonal() * J_gap_.transpose() +
                 J_gap_ramp_ * variance.asDiagonal() * J_gap_ramp_.transpose();
}

void MidpointIntegrator::add_steps(const SignalNode& a, const SignalNode& b, int steps) {
  if (b.time_s <= a.time_s) return;
  SignalNode from = a;
  for (int i = 1; i <= steps; ++i) {
    const SignalNode to = between(a, b, static_cast<double>(i) / steps);
    ramp_ = std::sqrt(3.0) * ((2.0 * i - 1.0) / steps - 1.0);  // mean square 1, like the constant
    step(from, to);
    from = to;
  }
}

template <int Columns>
void MidpointIntegrator::StepDerivative::carry(Eigen::Matrix<double, 9, Columns>& X) const {
  const Eigen::Matrix<double, 3, Columns> top = X.template topRows<3>();
  X.template bottomRows<3>() += A_p * top + h * X.template middleRows<3>(3);
  X.template middleRows<3>(3) += A_v * top;
  X.template topRows<3>() = A_R * top;
}

void MidpointIntegrator::step(const SignalNode& a, const SignalNode& b) {
  const double h = b.time_s - a.time_s;
  const Eigen::Vector3d rate = 0.5 * (a.rate + b.rate) - bias_.gyro;
  const Eigen::Vector3d force = 0.5 * (a.force + b.force) - bias_.accel;
  const SO3d half = SO3d::exp(0.5 * h * rate);
  const Eigen::Matrix3d M = (dR_ * half).matrix();
  const Eigen::Matrix3d M_force = -M * skew(force);  // M Exp(mu) force = M force + M_force mu
  const Eigen::Vector3d acceleration = M * force;

  StepDerivative d;
  d.h = h;
  d.A_R = (half * half).matrix().transpose();
  d.A_v = h * M_force * half.matrix().transpose();
  d.A_p = 0.5 * h * d.A_v;
  const Eigen::Matrix3d J_full = SO3d::right_jacobian(h * rate);
  const Eigen::Matrix3d J_half = 0.5 * M_force * SO3d::right_jacobian(0.5 * h * rate);
  d.B_rate << h * J_full, h * h * J_half, 0.5 * h * h * h * J_half;
  d.B_force << Eigen::Matrix3d::Zero(), h * M, 0.5 * h * h * M;
  d.b_length << J_full * rate, acceleration + h * J_half * rate,
      dv_ + h * acceleration + 0.5 * h * h * J_half * rate;
  advance_derivatives(d, a, b);

  dp_ += h * dv_ + 0.5 * h * h * acceleration;
  dv_ += h * acceleration;
  dR_ = dR_ * half * half;
}

void MidpointIntegrator::advance_derivatives(const StepDerivative& d,
                                             const SignalNode& a,
                                             const SignalNode& b) {
  // Neighbouring steps share a reading, yet their noise is taken as independent: the sum over many
  // steps has the right variance, and intervals that share an end do not count it twice.
  const double gyro_variance = noise_.gyro_noise_density * noise_.gyro_noise_density / d.h;
  const double accel_variance = noise_.accel_noise_density * noise_.accel_noise_density / d.h;
  d.carry(covariance_);
  covariance_.transposeInPlace();
  d.carry(covariance_);
  covariance_ += gyro_variance * d.B_rate * d.B_rate.transpose() +
                 accel_variance * d.B_force * d.B_force.transpose();
  // White noise inside the step: its double integral has h^3/3, of which h^3/4 is in B_force.
  covariance_.bottomRightCorner<3, 3>().diagonal().array() +=
      accel_variance * d.h * d.h * d.h * d.h / 12.0;
  add_variance(d, 0.5 / d.h * (a.gyro_variance + b.gyro_variance),
               0.5 / d.h * (a.accel_variance + b.accel_variance));

  d.carry(J_bias_);
  J_bias_.leftCols<3>() -= d.B_rate;
  J_bias_.rightCols<3>() -= d.B_force;

  d.carry(J_time_offset_);
  J_time_offset_ += d.B_rate * (0.5 * (a.rate_slope + b.rate_slope)) +
                    d.B_force * (0.5 * (a.force_slope + b.force_slope)) +
                    d.b_length * (b.time_slope - a.time_slope);
  if (in_gap_) {
    d.carry(J_gap_);
    J_gap_.leftCols<3>() += d.B_rate;
    J_gap_.rightCols<3>() += d.B_force;
    d.carry(J_gap_ramp_);
    J_gap_ramp_.leftCols<3>() += ramp_ * d.B_rate;
    J_gap_ramp_.rightCols<3>() += ramp_ * d.B_force;
  }
}

void MidpointIntegrator::add_variance(const StepDerivative& d,
                                      const Eigen::Vector3d& gyro,
                                      const Eigen::Vector3d& accel) {
  covariance_ += d.B_rate * gyro.asDiagonal() * d.B_rate.transpose() +
                 d.B_force * accel.asDiagonal() * d.B_force.transpose();
  // B_force is h M for the velocity; what is white inside the step has the axes of M, too.
  const Eigen::Matrix3d hM = d.B_force.middleRows<3>(3);
  covariance_.bottomRightCorner<3, 3>() +=
      d.h * d.h / 12.0 * (hM * accel.asDiagonal() * hM.transpose());
}

ImuMotion MidpointIntegrator::motion() const {
  ImuMotion motion;
  motion.dR = dR_;
  motion.dv = dv_;
  motion.dp = dp_;
  motion.covariance = 0.5 * (covariance_ + covariance_.transpose());
  motion.bias = bias_;
  motion.J_dR_bias = J_bias_.topRows<3>();
  motion.J_dv_bias = J_bias_.middleRows<3>(3);
  motion.J_dp_bias = J_bias_.bottomRows<3>();
  motion.J_time_offset = J_time_offset_;
  return motion;
}

}  // namespace imslam::imu

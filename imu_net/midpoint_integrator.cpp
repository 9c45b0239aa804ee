#include "imu_net/midpoint_integrator.hpp"

#include <algorithm>
#include <cmath>

namespace imslam::imu {

namespace {

constexpr int kGapSteps = 4;  ///< enough to tell a ramp from a constant

int step_count(const SignalNode& a, const SignalNode& b, double max_step_s) {
  const double steps = std::ceil((b.time_s - a.time_s) / max_step_s - 1e-9);
  return std::max(1, static_cast<int>(steps));
}

}  // namespace

MidpointIntegrator::MidpointIntegrator(const ImuBias& bias,
                                       const ImuNoise& noise,
                                       std::vector<RecordedStep>* record)
    : bias_(bias),
      gyro_density_sq_(noise.gyro_noise_density * noise.gyro_noise_density),
      accel_density_sq_(noise.accel_noise_density * noise.accel_noise_density),
      record_(record) {}

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
    const SignalNode to = i == steps ? b : between(a, b, static_cast<double>(i) / steps);
    ramp_ = std::sqrt(3.0) * ((2.0 * i - 1.0) / steps - 1.0);  // mean square 1, like the constant
    step(from, to);
    from = to;
  }
}

void MidpointIntegrator::step(const SignalNode& a, const SignalNode& b) {
  StepInput in;
  in.h = b.time_s - a.time_s;
  in.rate = 0.5 * (a.rate + b.rate) - bias_.gyro;
  in.force = 0.5 * (a.force + b.force) - bias_.accel;
  // Neighbouring steps share a reading, yet their noise is taken as independent: the sum over many
  // steps has the right variance, and intervals that share an end do not count it twice.
  in.rate_variance = (0.5 * (a.gyro_variance + b.gyro_variance).array() + gyro_density_sq_) / in.h;
  in.force_variance =
      (0.5 * (a.accel_variance + b.accel_variance).array() + accel_density_sq_) / in.h;
  RecordedStep taken{MidpointStep(in, dR_), {}, 0.5 * (a.time_s + b.time_s)};
  const MidpointStep& step = taken.step;
  taken.A_Sigma_R = step.carry_covariance(covariance_);
  if (record_ != nullptr) record_->push_back(taken);
  carry_bias(step);
  carry_time_offset(step, a, b);
  if (in_gap_) carry_gap(step);

  const Eigen::Vector3d acceleration = step.M * in.force;
  dp_ += in.h * dv_ + 0.5 * in.h * in.h * acceleration;
  dv_ += in.h * acceleration;
  dR_ = step.end();
}

void MidpointIntegrator::carry_bias(const MidpointStep& step) {
  step.carry(J_gyro_bias_);
  J_gyro_bias_ -= step.B_rate();
  const double h = step.in.h;
  J_accel_bias_.bottomRows<3>() += h * J_accel_bias_.topRows<3>() - 0.5 * h * h * step.M;
  J_accel_bias_.topRows<3>() -= h * step.M;
}

void MidpointIntegrator::carry_time_offset(const MidpointStep& step,
                                           const SignalNode& a,
                                           const SignalNode& b) {
  step.carry(J_time_offset_);
  if (a.time_slope == 0.0 && b.time_slope == 0.0) return;  // inner samples stay where they are
  const double h = step.in.h;
  const Eigen::Vector3d& rate = step.in.rate;
  const Eigen::Vector3d acceleration = step.M * step.in.force;
  Eigen::Matrix<double, 9, 1> b_length;  // derivative of the step by its length
  b_length << step.J_full * rate, acceleration + h * step.J_half * rate,
      dv_ + h * acceleration + 0.5 * h * h * step.J_half * rate;
  J_time_offset_ += step.B_rate() * (0.5 * (a.rate_slope + b.rate_slope)) +
                    step.B_force() * (0.5 * (a.force_slope + b.force_slope)) +
                    b_length * (b.time_slope - a.time_slope);
}

void MidpointIntegrator::carry_gap(const MidpointStep& step) {
  Eigen::Matrix<double, 9, 6> B;
  B << step.B_rate(), step.B_force();
  step.carry(J_gap_);
  J_gap_ += B;
  step.carry(J_gap_ramp_);
  J_gap_ramp_ += ramp_ * B;
}

ImuMotion MidpointIntegrator::motion() const {
  ImuMotion motion;
  motion.dR = dR_;
  motion.dv = dv_;
  motion.dp = dp_;
  motion.covariance = covariance_.matrix();
  motion.bias = bias_;
  motion.J_dR_bias << J_gyro_bias_.topRows<3>(), Eigen::Matrix3d::Zero();
  motion.J_dv_bias << J_gyro_bias_.middleRows<3>(3), J_accel_bias_.topRows<3>();
  motion.J_dp_bias << J_gyro_bias_.bottomRows<3>(), J_accel_bias_.bottomRows<3>();
  motion.J_time_offset = J_time_offset_;
  return motion;
}

}  // namespace imslam::imu

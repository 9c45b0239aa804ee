#include "slam/training/open_integration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"
#include "slam/base/time.hpp"
#include "slam/evaluation/statistics.hpp"
#include "slam/training/bounds.hpp"
#include "slam/training/true_time.hpp"

namespace imslam::training {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kEndTolerance = 0.05;     ///< of the window's length
constexpr double kInside95Bound = 16.919;  ///< 95 % of chi^2 with 9 dof
constexpr double kTwoSided95 = 1.959964;   ///< 97.5 % of N(0, 1)

std::vector<std::int64_t> stamps(const InertialLog& log) {
  std::vector<std::int64_t> times_ns;
  times_ns.reserve(log.truth.size());
  for (const auto& state : log.truth) times_ns.push_back(state.time_ns);
  return times_ns;
}

/// The sigma that holds at `time_ns`; before the first one: that one.
Vector6 bias_sigma_at(const std::vector<imu::StampedBiasSigma>& sigmas, std::int64_t time_ns) {
  if (sigmas.empty()) return Vector6::Zero();
  const auto later = std::upper_bound(
      sigmas.begin(), sigmas.end(), time_ns,
      [](std::int64_t t, const imu::StampedBiasSigma& s) { return t < s.time_ns; });
  const ImuBias& sigma = later == sigmas.begin() ? later->sigma : std::prev(later)->sigma;
  return (Vector6() << sigma.gyro, sigma.accel).finished();
}

WindowError compare(const ImuMotion& motion,
                    const IntegrationWindow& window,
                    const Vector6& bias_sigma) {
  WindowError error;
  error.first = window.first;
  error.difference = imu::difference(motion, window.motion);
  Eigen::Matrix<double, 9, 6> J;
  J << motion.J_dR_bias, motion.J_dv_bias, motion.J_dp_bias;
  const Eigen::Matrix<double, 9, 6> spread = J * bias_sigma.asDiagonal();
  error.covariance = motion.covariance + spread * spread.transpose() + window.motion.covariance;
  return error;
}

}  // namespace

void OpenIntegrationOptions::validate() const {
  require_within("windows [s]", window_s, 0.01, 1000.0);
  if (stride_s != 0.0) require_within("stride [s]", stride_s, 0.01, 1000.0);
  preintegration.validate();
}

std::vector<IntegrationWindow> integration_windows(const InertialLog& log,
                                                   const OpenIntegrationOptions& options) {
  const std::vector<std::int64_t> times_ns = stamps(log);
  const std::int64_t length_ns = to_nanoseconds(options.window_s);
  const std::int64_t stride_ns =
      to_nanoseconds(options.stride_s > 0.0 ? options.stride_s : options.window_s);
  const auto tolerance_ns = static_cast<std::int64_t>(kEndTolerance * to_seconds(length_ns) * 1e9);
  std::vector<IntegrationWindow> windows;
  for (std::size_t i = 0; i < times_ns.size();) {
    const auto end = index_near(times_ns, times_ns[i] + length_ns, tolerance_ns);
    const auto jump = std::upper_bound(log.truth_jumps.begin(), log.truth_jumps.end(), i);
    if (end && jump != log.truth_jumps.end() && *jump <= *end) {
      i = *jump;
      continue;
    }
    if (end && *end > i) windows.push_back(true_window(log, i, *end));
    const auto next = index_near(times_ns, times_ns[i] + stride_ns, tolerance_ns);
    i = next ? std::max(*next, i + 1) : i + 1;
  }
  return windows;
}

double WindowError::nees() const { return difference.dot(covariance.ldlt().solve(difference)); }

double WindowError::rotation_nees() const {
  const Eigen::Vector3d d = difference.head<3>();
  return d.dot(covariance.topLeftCorner<3, 3>().ldlt().solve(d));
}

double WindowError::negative_log_likelihood() const {
  const Eigen::LLT<Eigen::Matrix<double, 9, 9>> factor(covariance);
  const double log_root_determinant =
      factor.matrixLLT().diagonal().array().abs().log().sum();  // of L
  return 0.5 * nees() + log_root_determinant + 4.5 * std::log(2.0 * M_PI);
}

OpenIntegration integrate_open(const InertialLog& log,
                               const InertialCorrection& correction,
                               const OpenIntegrationOptions& options) {
  options.validate();
  const auto windows = integration_windows(log, options);
  std::vector<WindowError> errors(windows.size());
  std::vector<char> usable(windows.size(), 0);
  const imu::ImuRange samples(correction.corrected.samples);
  parallel_for(windows.size(), [&](std::size_t w) {
    const std::int64_t start_ns = windows[w].motion.time0_ns;
    const StampedBias* bias = bias_at(correction.start_bias, start_ns);
    const ImuMotion motion = imu::preintegrate(samples, start_ns, windows[w].motion.time1_ns,
                                               bias == nullptr ? ImuBias() : bias->bias, log.noise,
                                               0.0, options.preintegration);
    usable[w] = motion.valid && !motion.degraded ? 1 : 0;
    if (usable[w] == 0) return;
    errors[w] =
        compare(motion, windows[w], bias_sigma_at(correction.corrected.bias_sigma, start_ns));
  });
  OpenIntegration result;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (usable[w] != 0) {
      result.windows.push_back(errors[w]);
    } else {
      ++result.degraded;
    }
  }
  return result;
}

OpenScore score(const OpenIntegration& result) {
  OpenScore s;
  s.windows = result.windows.size();
  s.degraded = result.degraded;
  if (result.windows.empty()) return s;
  const auto count = static_cast<double>(s.windows);
  std::vector<double> rotation, velocity, position;
  for (const WindowError& w : result.windows) {
    rotation.push_back(w.difference.head<3>().norm() * 180.0 / M_PI);
    velocity.push_back(w.difference.segment<3>(3).norm());
    position.push_back(w.difference.tail<3>().norm());
    const double nees = w.nees();
    s.nees += nees / (9.0 * count);
    s.rotation_nees += w.rotation_nees() / (3.0 * count);
    s.inside_95 += (nees <= kInside95Bound ? 1.0 : 0.0) / count;
    s.negative_log_likelihood += w.negative_log_likelihood() / count;
  }
  const auto set = [](const std::vector<double>& errors, double& rms, double& median) {
    const auto statistics = evaluation::statistics(errors);
    rms = statistics.rmse;
    median = statistics.median;
  };
  set(rotation, s.rotation_rms_deg, s.rotation_median_deg);
  set(velocity, s.velocity_rms, s.velocity_median);
  set(position, s.position_rms, s.position_median);
  s.band_low = chi_squared_quantile(9.0 * count, -kTwoSided95) / (9.0 * count);
  s.band_high = chi_squared_quantile(9.0 * count, kTwoSided95) / (9.0 * count);
  return s;
}

double chi_squared_quantile(double dof, double normal_quantile) {
  const double spread = 2.0 / (9.0 * dof);
  return dof * std::pow(1.0 - spread + normal_quantile * std::sqrt(spread), 3.0);
}

}  // namespace imslam::training

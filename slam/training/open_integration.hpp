#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "imu_net/corrected_samples.hpp"
#include "imu_net/preintegration.hpp"
#include "slam/training/inertial_log.hpp"
#include "slam/training/truth_gravity.hpp"

namespace imslam::training {

/// What a method makes of a log.
struct InertialCorrection {
  imu::CorrectedSamples corrected;
  /// Subtracted from the readings over a whole window: the one that holds at its start. Empty:
  /// nothing is subtracted; `corrected` is already free of it.
  std::vector<StampedBias> start_bias;
};

struct OpenIntegrationOptions {
  double window_s = 1.0;  ///< [s]
  double stride_s = 0.0;  ///< [s] between the starts of windows; 0: they tile the log
  imu::PreintegrationOptions preintegration;

  void validate() const;  ///< throws InputError(kUsage)
};

/// Windows of one length from true state to true state. Where the truth has no state within 5 % of
/// the length of the end sought, there is no window; none spans a jump of the truth.
std::vector<IntegrationWindow> integration_windows(const InertialLog& log,
                                                   const OpenIntegrationOptions& options);

/// One window integrated from its true first state: how wrong it was, and what it said of itself.
struct WindowError {
  std::size_t first = 0;                   ///< index of the true state it begins with
  Eigen::Matrix<double, 9, 1> difference;  ///< imu::difference() to the truth [rad, m/s, m]
  /// Of the readings, of the bias at the start, of the truth: S = C + J diag(sigma)^2 J^T + T.
  Eigen::Matrix<double, 9, 9> covariance;

  double nees() const;                     ///< d^T S^-1 d, 9 dof
  double rotation_nees() const;            ///< of the rotation alone, 3 dof
  double negative_log_likelihood() const;  ///< of d ~ N(0, S), [rad, m/s, m]
};

struct OpenIntegration {
  std::vector<WindowError> windows;
  std::size_t degraded = 0;  ///< windows over gaps or saturation: left out
};

/// Integrates all windows of a log as corrected.
OpenIntegration integrate_open(const InertialLog& log,
                               const InertialCorrection& correction,
                               const OpenIntegrationOptions& options);

/// Errors and honesty over windows, of one log or of several put together.
///
///   nees = mean d^T S^-1 d / 9,  rotation_nees alike with 3: 1 if S is the truth about d
///   band: where 95 % of such means lie if d ~ N(0, S), windows independent (chi^2 / dof)
struct OpenScore {
  std::size_t windows = 0;
  std::size_t degraded = 0;
  double rotation_rms_deg = 0.0, rotation_median_deg = 0.0;
  double velocity_rms = 0.0, velocity_median = 0.0;  ///< [m/s]
  double position_rms = 0.0, position_median = 0.0;  ///< [m]
  double nees = 0.0, rotation_nees = 0.0;
  double inside_95 = 0.0;  ///< share of windows with d^T S^-1 d below the 95 % quantile
  double band_low = 0.0, band_high = 0.0;
  double negative_log_likelihood = 0.0;  ///< mean per window
};

/// All zero without windows.
OpenScore score(const OpenIntegration& result);

/// Quantile of chi^2 with `dof` degrees of freedom, by Wilson and Hilferty (PNAS 1931): within
/// 0.1 % for dof >= 9; `normal_quantile` is that of N(0, 1).
double chi_squared_quantile(double dof, double normal_quantile);

}  // namespace imslam::training

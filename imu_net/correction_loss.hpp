#pragma once

#include <cstdint>
#include <vector>

#include "imu_net/imu_network.hpp"
#include "imu_net/preintegration.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam::imu {

/// A log with truth, for training.
struct CorrectionTask {
  const std::vector<ImuSample>* samples = nullptr;
  ImuNoise noise;                         ///< datasheet
  std::vector<std::int64_t> frame_times;  ///< of the frames that the answer belongs to
  std::vector<ImuMotion> windows;         ///< times, dR, dv, dp and covariance of the truth
};

/// x up to 16, then 8 sqrt(x) - 16: one bad window does not rule.
double robust_square(double x);

/// Mean over the windows of the negative log-likelihood of the true motion, per degree of freedom:
///
///   m = preintegrate(corrected readings)    e = difference(m, truth)    P = Sigma_m + J S J^T + T
///   l = (robust_square(e^T P^-1 e / 9) + log det P / 9) / 2
///
/// S: the answer's sigmas squared at the window's start; J = dm/dbias; T: the truth's covariance.
/// Windows up to kLongestEdge_s have the answer's edge noise, longer ones its noise over seconds.
/// Windows that begin before the first frame, or in which a gap is bridged, do not count.
///
/// Backward through the mean and the covariance of the integration, exactly; J is taken as
/// constant.
template <typename S>
nn::Var correction_loss(nn::Tape<S>& tape, const ImuAnswer& answer, const CorrectionTask& task);

}  // namespace imslam::imu

#pragma once

#include "imu_net/imu_buffer.hpp"
#include "imu_net/midpoint_integrator.hpp"
#include "imu_net/preintegration.hpp"

namespace imslam::imu {

/// A stretch without usable samples.
struct Gap {
  const ImuSample* before = nullptr;  ///< the last usable sample; null: none
  const ImuSample* after = nullptr;   ///< the next one; null: none
  double length_s = 0.0;              ///< [s] between them, or to the far end of the interval
  bool saturated = false;             ///< a reading inside was at the limit of the range
};

/// How far the truth may be from the bridge across the gap (linear between two ends, held beyond
/// one); `samples` are those around, which tell the vibration. At least one end must be there.
///
///   motion      share * (floor + strength),  share -> 1 for long gaps: with the square of the
///               length between two ends, linearly beyond one end and where readings were clipped
///   vibration   the ends' own scatter, which the bridge carries all along the gap
///
/// The bridge errs the same way all along the gap, but each of the n = length / interval_s
/// intervals [s] it spans is weighed by itself. Their variances are n times as large, so that
/// together they know the motion across the gap as well as one interval over all of it would.
GapSpread gap_spread(const Gap& gap,
                     double interval_s,
                     ImuRange samples,
                     const ImuBias& bias,
                     const ImuNoise& noise,
                     const PreintegrationOptions& options);

}  // namespace imslam::imu

#pragma once

#include <optional>

#include "imu_net/gap_model.hpp"
#include "imu_net/imu_buffer.hpp"
#include "imu_net/midpoint_integrator.hpp"
#include "imu_net/preintegration.hpp"
#include "imu_net/preintegration_record.hpp"
#include "slam/base/time.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"

namespace imslam::imu {

/// Walks over the usable samples around one interval and hands each stretch to the integrator;
/// see preintegrate().
class IntervalWalk {
 public:
  /// `frame`: times, bias and offset of the interval, and what is returned if nothing is known of
  /// it. Noise and options must outlive the walk; the steps go to `record`, too, if there is one.
  IntervalWalk(ImuRange samples,
               ImuMotion frame,
               const ImuNoise& noise,
               const PreintegrationOptions& options,
               PreintegrationRecord* record);

  ImuMotion run();

 private:
  double seconds(const ImuSample& sample) const {
    return to_seconds(sample.time_ns - frame_.time0_ns);
  }
  SignalNode node(const ImuSample& sample) const;
  const ImuSample* first_sample() const;
  void visit(const ImuSample& sample);
  void stretch(const SignalNode& a, const SignalNode& b, const Gap& gap);
  void note_sources(const Gap& gap);

  ImuRange samples_;
  ImuMotion frame_;
  const ImuNoise& noise_;
  const PreintegrationOptions& options_;
  double start_s_;
  double end_s_;
  PreintegrationRecord* record_;
  MidpointIntegrator integrator_;
  std::optional<SignalNode> last_;  ///< the newest usable sample
  const ImuSample* last_sample_ = nullptr;
  bool dropped_ = false;    ///< a reading was refused since `last_`
  bool saturated_ = false;  ///< it was at the limit of the range
  bool degraded_ = false;
  bool lost_ = false;
};

}  // namespace imslam::imu

#include "imu_net/preintegration_gradient.hpp"

#include "imu_net/midpoint_step_gradient.hpp"

namespace imslam::imu {
namespace {

void add(const StepGradient& step, double h, double share, SampleGradient& sample) {
  sample.angular_velocity += share * step.rate;
  sample.linear_acceleration += share * step.force;
  sample.gyro_variance += share / h * step.rate_variance;
  sample.accel_variance += share / h * step.force_variance;
}

}  // namespace

ImuBias add_preintegration_gradient(const PreintegrationRecord& record,
                                    const MotionGradient& dL,
                                    SampleGradient* gradients) {
  StateGradient state;
  state.R = dL.motion.head<3>();
  state.v = dL.motion.segment<3>(3);
  state.p = dL.motion.tail<3>();
  state.Sigma = SymmetricBlocks(dL.covariance);

  ImuBias bias;
  for (std::size_t i = record.steps.size(); i-- > 0;) {
    const RecordedStep& recorded = record.steps[i];
    const StepGradient step = pull_back(recorded.step, recorded.A_Sigma_R, state);
    const StepSource& source = record.sources[i];
    const double h = recorded.step.in.h;
    add(step, h, 1.0 - source.share_after, gradients[source.before - record.samples.begin()]);
    add(step, h, source.share_after, gradients[source.after - record.samples.begin()]);
    bias.gyro -= step.rate;
    bias.accel -= step.force;
  }
  return bias;
}

}  // namespace imslam::imu

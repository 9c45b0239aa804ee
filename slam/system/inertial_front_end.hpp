#pragma once

#include <memory>
#include <vector>

#include "imu_net/imu_corrector.hpp"
#include "slam/system/measurements.hpp"

namespace imslam::system {

/// The learned correction as the graph wants it.
///
/// The graph has bias states of its own. A correction that changes under them would look like a
/// bias that jumps, so the readings keep their values: what the network knows of the bias goes to
/// the graph as a belief with a standard deviation, once per axis, from the moment when it was
/// surest. Of its noise the readings take the variances.
class InertialFrontEnd {
 public:
  InertialFrontEnd(std::shared_ptr<const imu::ImuNetwork<float>> network, const ImuNoise& noise)
      : corrector_(std::move(network), noise) {}

  /// The reading with the variances that the network adds. Stamps must increase.
  ImuSample add(const ImuSample& sample);

  /// One per axis; none before the network has said anything.
  const std::vector<BiasBelief>& beliefs() const { return beliefs_; }
  /// The newest one.
  ImuBias bias() const;

 private:
  void believe(const imu::ImuCorrection& said);

  imu::ImuCorrector corrector_;
  std::vector<BiasBelief> beliefs_;
  std::int64_t believed_ns_ = 0;  ///< time of the correction that was looked at last
};

}  // namespace imslam::system

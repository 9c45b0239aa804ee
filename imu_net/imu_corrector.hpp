#pragma once

#include <deque>
#include <memory>

#include "imu_net/corrected_samples.hpp"
#include "imu_net/imu_buffer.hpp"
#include "imu_net/imu_features.hpp"
#include "imu_net/imu_network.hpp"

namespace imslam::imu {

/// White noise as densities squared, axis by axis; see ImuSample.
struct ImuNoiseVariance {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< [(rad/s)^2/Hz]
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< [(m/s^2)^2/Hz]
};

/// Density squared of noise that is e^log_ratio times as dense as the datasheet's.
double added_variance(double datasheet_density, double log_ratio);

/// What the network last said, in numbers; holds from `time_ns` on.
struct ImuCorrection {
  std::int64_t time_ns = 0;
  ImuBias offset;               ///< to be subtracted
  ImuNoiseVariance noise;       ///< to be added, for integrations over seconds
  ImuNoiseVariance edge_noise;  ///< likewise, for the short edges of a graph
  ImuBias sigma;                ///< how wrong the offset may still be
};

/// The reading with the offset subtracted and the noise over seconds added. One that is broken or
/// at the limit of the range is returned as it is, so that preintegration still sees it for what it
/// is.
ImuSample corrected(const ImuSample& sample,
                    const ImuCorrection& correction,
                    const ImuNoise& noise);

/// Corrects a stream of readings; causal, state of fixed size, no allocation per reading once warm.
class ImuCorrector {
 public:
  ImuCorrector(std::shared_ptr<const ImuNetwork<float>> network, const ImuNoise& noise);

  /// Stamps must increase. Before the first bin is full readings stay as they are.
  ImuSample correct(const ImuSample& sample);

  /// Null until the network has said something.
  const ImuCorrection* correction() const { return said_ ? &correction_ : nullptr; }

 private:
  void look(const ImuFrame& frame);

  std::shared_ptr<const ImuNetwork<float>> network_;
  ImuNoise noise_;
  FeatureExtractor extractor_;
  ImuFrameTensors<float> frames_;  ///< the last ones, the newest at the end
  nn::Tensor<float> state_;
  nn::Tape<float> tape_{nn::Mode::kInference};
  ImuCorrection correction_;
  bool said_ = false;
};

/// A whole log, exactly as ImuCorrector would have streamed it.
CorrectedSamples correct_samples(const std::shared_ptr<const ImuNetwork<float>>& network,
                                 ImuRange samples,
                                 const ImuNoise& noise);

}  // namespace imslam::imu

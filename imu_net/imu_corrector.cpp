#include "imu_net/imu_corrector.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "imu_net/sample_health.hpp"

namespace imslam::imu {

namespace {

using nn::Index;

constexpr Index kContext = ImuNetwork<float>::kContext;
constexpr double kMostSigma = 2.0;  // of what the sensor's kind allows

/// Number `channel` of axis `axis` of a value [3,1,2].
double number(const nn::Tape<float>& tape, nn::Var v, int axis, int channel) {
  return static_cast<double>(tape.data(v)[2 * axis + channel]);
}

}  // namespace

double added_variance(double datasheet_density, double log_ratio) {
  return datasheet_density * datasheet_density * std::exp(2.0 * log_ratio);
}

ImuSample corrected(const ImuSample& sample,
                    const ImuCorrection& correction,
                    const ImuNoise& noise) {
  if (sample_health(sample, noise) != SampleHealth::kGood) return sample;
  ImuSample result = sample;
  result.angular_velocity -= correction.offset.gyro;
  result.linear_acceleration -= correction.offset.accel;
  result.gyro_variance += correction.noise.gyro;
  result.accel_variance += correction.noise.accel;
  return result;
}

ImuCorrector::ImuCorrector(std::shared_ptr<const ImuNetwork<float>> network, const ImuNoise& noise)
    : network_(std::move(network)),
      noise_(noise),
      extractor_(noise),
      frames_{nn::Tensor<float>({3, kContext + 1, ImuFrame::kFeatures}),
              nn::Tensor<float>({3, 1, ImuFrame::kGyroCandidates}),
              nn::Tensor<float>({3, 1, ImuFrame::kAccelCandidates}), largest_offset(noise)},
      state_({3, network_->gru.hidden()}) {}

ImuSample ImuCorrector::correct(const ImuSample& sample) {
  for (const ImuFrame& frame : extractor_.add(sample)) look(frame);
  return said_ ? corrected(sample, correction_, noise_) : sample;
}

void ImuCorrector::look(const ImuFrame& frame) {
  constexpr Index kFeatures = ImuFrame::kFeatures;
  for (Index axis = 0; axis < 3; ++axis) {
    float* const rows = frames_.features.data() + axis * (kContext + 1) * kFeatures;
    std::copy(rows + kFeatures, rows + (kContext + 1) * kFeatures, rows);
    const auto& newest = frame.features[static_cast<std::size_t>(axis)];
    std::copy(newest.begin(), newest.end(), rows + kContext * kFeatures);
    put_candidates(frame, axis, 0, frames_);
  }
  tape_.reset();
  const ImuAnswer answer = network_->forward(tape_, frames_, tape_.constant(state_));
  std::copy_n(tape_.data(answer.state), state_.size(), state_.data());

  said_ = true;
  correction_.time_ns = frame.time_ns;
  for (int axis = 0; axis < 3; ++axis) {
    const auto of = [&](nn::Var v, int sensor) { return number(tape_, v, axis, sensor); };
    correction_.offset.gyro[axis] = of(answer.offset, 0);
    correction_.offset.accel[axis] = of(answer.offset, 1);
    correction_.noise.gyro[axis] = added_variance(noise_.gyro_noise_density, of(answer.noise, 0));
    correction_.noise.accel[axis] = added_variance(noise_.accel_noise_density, of(answer.noise, 1));
    correction_.edge_noise.gyro[axis] =
        added_variance(noise_.gyro_noise_density, of(answer.edge_noise, 0));
    correction_.edge_noise.accel[axis] =
        added_variance(noise_.accel_noise_density, of(answer.edge_noise, 1));
    correction_.sigma.gyro[axis] =
        std::min(std::exp(of(answer.log_sigma, 0)), kMostSigma * noise_.gyro_bias_sigma);
    correction_.sigma.accel[axis] =
        std::min(std::exp(of(answer.log_sigma, 1)), kMostSigma * noise_.accel_bias_sigma);
  }
}

CorrectedSamples correct_samples(const std::shared_ptr<const ImuNetwork<float>>& network,
                                 ImuRange samples,
                                 const ImuNoise& noise) {
  CorrectedSamples result;
  result.samples.reserve(samples.size());
  ImuCorrector corrector(network, noise);
  for (const ImuSample& sample : samples) {
    result.samples.push_back(corrector.correct(sample));
    const ImuCorrection* const said = corrector.correction();
    if (said == nullptr) continue;
    if (result.bias_sigma.empty() || result.bias_sigma.back().time_ns != said->time_ns) {
      result.bias_sigma.push_back({said->time_ns, said->sigma});
    }
  }
  return result;
}

}  // namespace imslam::imu

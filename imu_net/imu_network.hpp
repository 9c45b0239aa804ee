#pragma once

#include <string>

#include "imu_net/imu_features.hpp"
#include "slam/base/random.hpp"
#include "slam/nn/layers/conv.hpp"
#include "slam/nn/layers/gru.hpp"
#include "slam/nn/layers/linear.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::imu {

/// Sizes of the network. Those of the shipped weights are the defaults.
struct ImuNetworkSizes {
  int width = 64;   ///< channels of the convolutions
  int hidden = 96;  ///< of the recurrent state
  int head = 64;    ///< of the last layer but one
};

/// Frames as the network takes them: three axes side by side.
template <typename S>
struct ImuFrameTensors {
  nn::Tensor<S> features;    ///< [3, context + T, F]; the context comes before what is asked
  nn::Tensor<S> gyro_bias;   ///< [3, T, 3] candidates
  nn::Tensor<S> accel_bias;  ///< [3, T, 1]
  /// Of the offsets: what the sensor's kind may show [rad/s], [m/s^2].
  std::array<double, 2> largest_offset{0.3, 1.0};
};

/// Three sigmas of the gyro's bias, five of the accelerometer's: 0.3 rad/s and 1 m/s^2 unless the
/// sensor is known to be better.
std::array<double, 2> largest_offset(const ImuNoise& noise);

/// Writes the candidates of one frame at place `bin`.
template <typename S>
void put_candidates(const ImuFrame& frame,
                    nn::Index axis,
                    nn::Index bin,
                    ImuFrameTensors<S>& tensors) {
  const nn::Index row = axis * tensors.gyro_bias.shape()[1] + bin;
  for (int k = 0; k < ImuFrame::kGyroCandidates; ++k) {
    tensors.gyro_bias[row * ImuFrame::kGyroCandidates + k] =
        static_cast<S>(frame.gyro_bias[static_cast<std::size_t>(k)][axis]);
  }
  for (int k = 0; k < ImuFrame::kAccelCandidates; ++k) {
    tensors.accel_bias[row * ImuFrame::kAccelCandidates + k] =
        static_cast<S>(frame.accel_bias[static_cast<std::size_t>(k)][axis]);
  }
}

/// All frames of a log; the context before the first is zero.
template <typename S>
ImuFrameTensors<S> frame_tensors(const std::vector<ImuFrame>& frames, const ImuNoise& noise);

/// What the network says for each axis and bin.
struct ImuAnswer {
  nn::Var offset;      ///< [3, T, 2] of gyro, accelerometer: to be subtracted [rad/s], [m/s^2]
  nn::Var noise;       ///< [3, T, 2] log of the added density over the datasheet's, over seconds
  nn::Var edge_noise;  ///< [3, T, 2] the same over the short edges of a graph, see kLongestEdge_s
  nn::Var log_sigma;   ///< [3, T, 2] log of how wrong the bias may still be [rad/s], [m/s^2]
  nn::Var state;       ///< [3, hidden] to go on with
};

/// Corrections of an inertial sensor from its own readings: which of the observers' biases to
/// believe, how noisy the readings are, how wrong the bias may still be.
///
///   h_t = GRU(conv(conv(features)))         a, n, s = head(h_t)          per axis, shared weights
///   offset = B tanh((o + sum_k a_k (c_k - o)) / B),   |a_k| < 2,   c_k candidates,   o constant,
///                                                      B largest_offset
///   noise = -4 + n within (-13, 5)          log sigma = log sigma_0 + s
///
/// Over seconds errors of scale and alignment look like noise that short integrations do not have:
/// hence two noises. The last layer starts at zero and so does o: an untrained network subtracts
/// nothing. o is the only part that knows one sensor from another: it stays zero unless trained on
/// logs of one.
template <typename S>
struct ImuNetwork {
  static constexpr double kLongestEdge_s = 0.5;  ///< [s] integrations up to it have edge_noise
  static constexpr int kContext = 10;            ///< [bins] that the convolutions look back

  ImuNetwork(const ImuNetworkSizes& sizes, Random& random);

  /// `state` [3, hidden] of the bins before, or gru.zero_state(). `own_sensor` false: the frames
  /// are of another sensor than the one whose offset is known, o = 0.
  ImuAnswer forward(nn::Tape<S>& tape,
                    const ImuFrameTensors<S>& frames,
                    nn::Var state,
                    bool own_sensor = true) const;

  void collect(nn::ParameterList<S>& list, const std::string& prefix = "");

  ImuBias reading_offset() const;  ///< sensor_offset by axes
  void set_reading_offset(const ImuBias& offset);

  nn::Conv1d<S> near, far;
  nn::Gru<S> gru;
  nn::Linear<S> middle, last;
  nn::Parameter<S> sensor_offset;  ///< [3, 1, 2] of gyro, accelerometer [rad/s], [m/s^2]
};

}  // namespace imslam::imu

#include "imu_net/imu_network.hpp"

#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/reduce.hpp"

namespace imslam::imu {
namespace {

using nn::Index;
using nn::Var;

constexpr int kNearKernel = 3;
constexpr int kFarKernel = 5;
constexpr int kFarDilation = 2;
constexpr double kLargestCoefficient = 2.0;
constexpr double kFirstNoise = -4.0;                // e^-4 of the datasheet's density: nothing
constexpr double kNoiseReach = 9.0;                 // most and least: kFirstNoise +- kNoiseReach
constexpr double kFirstLogSigma[2] = {-4.0, -2.0};  // 0.018 rad/s, 0.14 m/s^2
constexpr double kSigmaReach = 6.0;

constexpr int kGyro = ImuFrame::kGyroCandidates;
constexpr int kAccel = ImuFrame::kAccelCandidates;
constexpr int kOutputs = kGyro + kAccel + 6;

template <typename S>
nn::Conv1d<S> convolution(int inputs, int outputs, int kernel, int dilation, Random& random) {
  nn::ConvolutionOptions how;
  how.dilation_x = dilation;
  return {inputs, outputs, kernel, how, random};
}

/// reach tanh(x / reach): like x near 0.
template <typename S>
Var within(nn::Tape<S>& tape, Var x, double reach) {
  return scale(tape, tanh(tape, scale(tape, x, 1.0 / reach)), reach);
}

/// B tanh((o + sum a (c - o)) / B)
template <typename S>
Var blend(nn::Tape<S>& tape, Var coefficients, Var candidates, Var constant, double largest) {
  const Var bounded = within(tape, coefficients, kLargestCoefficient);
  const Var off = subtract(tape, candidates, constant);
  const Var moved = sum(tape, multiply(tape, bounded, off), {-1}, nn::Axes::kKeep);
  return within(tape, add(tape, moved, constant), largest);
}

}  // namespace

template <typename S>
ImuNetwork<S>::ImuNetwork(const ImuNetworkSizes& sizes, Random& random)
    : near(convolution<S>(ImuFrame::kFeatures, sizes.width, kNearKernel, 1, random)),
      far(convolution<S>(sizes.width, sizes.width, kFarKernel, kFarDilation, random)),
      gru(sizes.width, sizes.hidden, random),
      middle(sizes.hidden, sizes.head, random),
      last(sizes.head, kOutputs, random),
      sensor_offset(nn::Shape{3, 1, 2}) {
  static_assert(kContext == kNearKernel - 1 + kFarDilation * (kFarKernel - 1));
  last.weight.value.array() = S(0);
}

template <typename S>
ImuAnswer ImuNetwork<S>::forward(nn::Tape<S>& tape,
                                 const ImuFrameTensors<S>& frames,
                                 Var state,
                                 bool own_sensor) const {
  const Index bins = frames.gyro_bias.shape()[1];
  nn::expects_shape(frames.features.shape() == nn::Shape{3, kContext + bins, ImuFrame::kFeatures},
                    "ImuNetwork::forward: features [3, context + T, F]", frames.features.shape());
  const Var seen = gelu(tape, near.forward(tape, tape.constant(frames.features)));
  const Var felt = gelu(tape, far.forward(tape, seen));
  const Var states = gru.forward(tape, felt, state);
  const Var said = last.forward(tape, gelu(tape, middle.forward(tape, states)));
  const auto part = [&](Index start, Index count) { return slice(tape, said, -1, start, count); };
  const Var constant = own_sensor ? tape.parameter(sensor_offset)
                                  : tape.constant(nn::Tensor<S>(sensor_offset.value.shape()));
  const auto constant_of = [&](Index sensor) { return slice(tape, constant, -1, sensor, 1); };

  ImuAnswer answer;
  answer.offset = concat(tape,
                         {blend(tape, part(0, kGyro), tape.constant(frames.gyro_bias),
                                constant_of(0), frames.largest_offset[0]),
                          blend(tape, part(kGyro, kAccel), tape.constant(frames.accel_bias),
                                constant_of(1), frames.largest_offset[1])},
                         -1);
  const auto noise = [&](Index start) {
    return shift(tape, within(tape, part(start, 2), kNoiseReach), kFirstNoise);
  };
  answer.noise = noise(kGyro + kAccel);
  answer.edge_noise = noise(kGyro + kAccel + 2);
  const Var sigma = within(tape, part(kGyro + kAccel + 4, 2), kSigmaReach);
  answer.log_sigma = concat(tape,
                            {shift(tape, slice(tape, sigma, -1, 0, 1), kFirstLogSigma[0]),
                             shift(tape, slice(tape, sigma, -1, 1, 1), kFirstLogSigma[1])},
                            -1);
  answer.state = last_state(tape, states);
  return answer;
}

template <typename S>
void ImuNetwork<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  near.collect(list, prefix + "near.");
  far.collect(list, prefix + "far.");
  gru.collect(list, prefix + "gru.");
  middle.collect(list, prefix + "middle.");
  last.collect(list, prefix + "last.");
  list.add(prefix + "sensor_offset", sensor_offset);
}

template <typename S>
ImuBias ImuNetwork<S>::reading_offset() const {
  ImuBias offset;
  for (Index axis = 0; axis < 3; ++axis) {
    offset.gyro[axis] = static_cast<double>(sensor_offset.value[2 * axis]);
    offset.accel[axis] = static_cast<double>(sensor_offset.value[2 * axis + 1]);
  }
  return offset;
}

template <typename S>
void ImuNetwork<S>::set_reading_offset(const ImuBias& offset) {
  for (Index axis = 0; axis < 3; ++axis) {
    sensor_offset.value[2 * axis] = static_cast<S>(offset.gyro[axis]);
    sensor_offset.value[2 * axis + 1] = static_cast<S>(offset.accel[axis]);
  }
}

std::array<double, 2> largest_offset(const ImuNoise& noise) {
  return {3.0 * noise.gyro_bias_sigma, 5.0 * noise.accel_bias_sigma};
}

template <typename S>
ImuFrameTensors<S> frame_tensors(const std::vector<ImuFrame>& frames, const ImuNoise& noise) {
  const auto bins = static_cast<Index>(frames.size());
  constexpr Index kFeatures = ImuFrame::kFeatures;
  constexpr Index kContext = ImuNetwork<S>::kContext;
  ImuFrameTensors<S> tensors{nn::Tensor<S>({3, kContext + bins, kFeatures}),
                             nn::Tensor<S>({3, bins, kGyro}), nn::Tensor<S>({3, bins, kAccel}),
                             largest_offset(noise)};
  for (Index axis = 0; axis < 3; ++axis) {
    for (Index bin = 0; bin < bins; ++bin) {
      const ImuFrame& frame = frames[static_cast<std::size_t>(bin)];
      const auto& row = frame.features[static_cast<std::size_t>(axis)];
      S* const out =
          tensors.features.data() + (axis * (kContext + bins) + kContext + bin) * kFeatures;
      for (Index i = 0; i < kFeatures; ++i)
        out[i] = static_cast<S>(row[static_cast<std::size_t>(i)]);
      put_candidates(frame, axis, bin, tensors);
    }
  }
  return tensors;
}

template ImuFrameTensors<float> frame_tensors(const std::vector<ImuFrame>&, const ImuNoise&);
template ImuFrameTensors<double> frame_tensors(const std::vector<ImuFrame>&, const ImuNoise&);
template struct ImuNetwork<float>;
template struct ImuNetwork<double>;

}  // namespace imslam::imu

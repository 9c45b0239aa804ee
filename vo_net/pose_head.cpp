#include "vo_net/pose_head.hpp"

#include "slam/nn/ops/activation.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/normalise.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "vo_net/derotation.hpp"
#include "vo_net/flow_grid.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;

constexpr double kLongest = 6.0;  // [medians] of a flow; what lies beyond is an outlier anyway
constexpr int kInputs = 9;        // flow 2, confidence 1, place 2, products 4
constexpr int kOutputs = 10;      // rotation 3, direction 3, log sigmas 3 + 1
constexpr double kFirstWeights = 0.05;  // bound of the untrained output's weights
// A scale that the network says is bounded below: an error of 0 must not pay without end.
constexpr double kLeastLogSigma = -6.0;

template <typename S>
nn::Conv2d<S> convolution(int inputs, int outputs, int stride, Random& random) {
  nn::ConvolutionOptions how = nn::ConvolutionOptions::square(stride, 1);
  how.activation = nn::Activation::kRelu;
  return {inputs, outputs, 3, how, random};
}

/// [kLongest tanh(f / kLongest), confidence, x, y, x f, y f]
template <typename S>
Var features(nn::Tape<S>& tape, Var unit_flow, Var confidence, Var place) {
  const Var squashed = scale(tape, tanh(tape, scale(tape, unit_flow, 1.0 / kLongest)), kLongest);
  const Var x = slice(tape, place, -1, 0, 1);
  const Var y = slice(tape, place, -1, 1, 1);
  return concat(
      tape, {squashed, confidence, place, multiply(tape, squashed, x), multiply(tape, squashed, y)},
      -1);
}

/// floor + softplus(x - floor).
template <typename S>
Var bounded_below(nn::Tape<S>& tape, Var x, double floor) {
  return shift(tape, softplus(tape, shift(tape, x, -floor)), floor);
}

}  // namespace

template <typename S>
FlowBlock<S>::FlowBlock(int channels, Random& random)
    : first(convolution<S>(channels, channels, 1, random)),
      second(convolution<S>(channels, channels, 1, random)) {
  second.options.activation = nn::Activation::kNone;
}

template <typename S>
Var FlowBlock<S>::forward(nn::Tape<S>& tape, Var x) const {
  return add_relu(tape, x, second.forward(tape, first.forward(tape, x)));
}

template <typename S>
void FlowBlock<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  first.collect(list, prefix + "first.");
  second.collect(list, prefix + "second.");
}

template <typename S>
PoseHead<S>::PoseHead(const PoseHeadSizes& s, Random& random)
    : sizes(s),
      to_fine(convolution<S>(kInputs, s.fine, 2, random)),
      to_middle(convolution<S>(s.fine, s.middle, 2, random)),
      to_coarse(convolution<S>(s.middle, s.coarse, 2, random)),
      middle(s.middle, random),
      coarse(s.coarse, random),
      hidden(
          static_cast<int>(FlowGrid::kRows * FlowGrid::kColumns) / 64 * s.coarse, s.hidden, random),
      second(s.hidden, s.hidden, random),
      output(s.hidden, kOutputs, random) {
  expects(s.passes >= 1, "PoseHead: at least one look");
  initialise_uniform(output.weight, kFirstWeights, random);
}

template <typename S>
Var PoseHead<S>::look(nn::Tape<S>& tape, Var flow, Var confidence, Var place) const {
  const Var seen = to_fine.forward(tape, features(tape, flow, confidence, place));
  const Var near = middle.forward(tape, to_middle.forward(tape, seen));
  const Var far = coarse.forward(tape, to_coarse.forward(tape, near));
  const nn::Shape shape = tape.shape(far);
  const Var all = reshape(tape, far, {shape[0], shape.size() / shape[0]});
  const Var concluded =
      second.forward(tape, hidden.forward(tape, all, nn::Activation::kRelu), nn::Activation::kRelu);
  return output.forward(tape, concluded);
}

template <typename S>
std::vector<PoseHeadOutput> PoseHead<S>::forward(nn::Tape<S>& tape, Var grids) const {
  const nn::Shape shape = tape.shape(grids);
  nn::expects_shape(shape.rank() == 4 && shape[1] == FlowGrid::kRows &&
                        shape[2] == FlowGrid::kColumns && shape[3] == FlowGrid::kChannels &&
                        shape[0] >= 1,
                    "PoseHead::forward: grids [N,32,48,5]", shape);
  const Index samples = shape[0];
  const Var flow = slice(tape, grids, -1, FlowGrid::kFlowX, 2);
  const Var confidence = slice(tape, grids, -1, FlowGrid::kConfidence, 1);
  const Var place = slice(tape, grids, -1, FlowGrid::kPlaceX, 2);
  std::vector<PoseHeadOutput> looks;
  Var theta;
  for (int pass = 0; pass < sizes.passes; ++pass) {
    const Var left = pass == 0 ? flow : derotate(tape, flow, place, confidence, theta);
    const Var unit = median_length(tape, left, confidence);
    const Var said = look(tape, divide(tape, left, unit), confidence, place);
    const auto part = [&](Index start, Index count) { return slice(tape, said, -1, start, count); };
    const Var units = reshape(tape, unit, {samples, 1});
    const Var turn = multiply(tape, part(0, 3), units);
    theta = pass == 0 ? turn : compose_rotations(tape, theta, turn);
    PoseHeadOutput result;
    result.rotation = theta;
    result.direction = l2_normalise(tape, part(3, 3));
    result.log_sigma_rotation =
        add(tape, bounded_below(tape, part(6, 3), kLeastLogSigma), log(tape, units));
    result.log_sigma_direction = bounded_below(tape, part(9, 1), kLeastLogSigma);
    looks.push_back(result);
  }
  return looks;
}

template <typename S>
void PoseHead<S>::collect(nn::ParameterList<S>& list, const std::string& prefix) {
  to_fine.collect(list, prefix + "to_fine.");
  to_middle.collect(list, prefix + "to_middle.");
  to_coarse.collect(list, prefix + "to_coarse.");
  middle.collect(list, prefix + "middle.");
  coarse.collect(list, prefix + "coarse.");
  hidden.collect(list, prefix + "hidden.");
  second.collect(list, prefix + "second.");
  output.collect(list, prefix + "output.");
}

template struct FlowBlock<float>;
template struct FlowBlock<double>;
template struct PoseHead<float>;
template struct PoseHead<double>;

}  // namespace imslam::vo

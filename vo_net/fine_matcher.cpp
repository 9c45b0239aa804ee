#include "vo_net/fine_matcher.hpp"

#include <cmath>

#include "slam/nn/layers/initialise.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/normalise.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/sampling.hpp"

namespace imslam::vo {
namespace {

constexpr double kFirstScale = 16.0;  // of cosines: neighbours differ little, features are smooth

}  // namespace

template <typename S>
FineMatcher<S>::FineMatcher(const MatchNetworkOptions& options, int stride_px)
    : stride(stride_px), window(options.fine_window()), sharpness(nn::Shape{1}) {
  initialise_constant(sharpness, std::log(kFirstScale));
}

template <typename S>
typename FineMatcher<S>::Match FineMatcher<S>::forward(
    nn::Tape<S>& tape, nn::Var f0, nn::Var f1, nn::Var points, nn::Var guess) const {
  const nn::Shape shape = tape.shape(points);
  nn::expects_shapes(shape == tape.shape(guess), "FineMatcher::forward: a guess per point", shape,
                     tape.shape(guess));
  Match match;
  match.level.stride = stride;
  match.level.window = window;
  match.level.origin = tape.make(shape);
  const nn::Var middles = tape.make(shape);
  const S size = static_cast<S>(stride);
  tape.array(middles) = ((tape.array(points) + tape.array(guess)) / size + S(0.5)).floor();
  tape.array(match.level.origin) = tape.array(middles) * size - tape.array(points);

  const nn::Var read =
      bilinear_sample(tape, f0, scale(tape, points, 1.0 / stride), nn::Border::kClamp);
  match.query = l2_normalise(tape, read);
  match.cosines = correlate_points(tape, match.query, f1, middles, window, nn::Centre::kRounded);
  match.level.logits = multiply(tape, match.cosines, exp(tape, tape.parameter(sharpness)));
  const nn::Var cells = local_soft_argmax(tape, match.level.logits, window);
  match.level.displacement = add(tape, match.level.origin, scale(tape, cells, stride));
  return match;
}

template struct FineMatcher<float>;
template struct FineMatcher<double>;

}  // namespace imslam::vo

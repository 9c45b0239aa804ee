#include "vo_net/match_loss.hpp"

#include <cmath>

#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/losses.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/reduce.hpp"
#include "vo_net/options_check.hpp"

namespace imslam::vo {
namespace {

using nn::Index;
using nn::Var;

constexpr double kDegreesOfFreedom = 3.0;

/// Spreads one number over the four cells around (x, y); false if one of them is not in the window.
template <typename S>
bool spread(const nn::Window& window, double x, double y, S* target) {
  const double x0 = std::floor(x);
  const double y0 = std::floor(y);
  if (!(x0 >= window.x_min && x <= window.x_max && y0 >= window.y_min && y <= window.y_max)) {
    return false;
  }
  for (int dy = 0; dy <= 1; ++dy) {
    for (int dx = 0; dx <= 1; ++dx) {
      const double weight = (1.0 - std::abs(x - x0 - dx)) * (1.0 - std::abs(y - y0 - dy));
      if (weight <= 0.0) continue;
      const int column = static_cast<int>(x0) + dx - window.x_min;
      const int row = static_cast<int>(y0) + dy - window.y_min;
      target[row * window.columns() + column] = static_cast<S>(weight);
    }
  }
  return true;
}

template <typename S>
Var level_loss(nn::Tape<S>& tape, const LevelMatch& level, const MatchTruth<S>& truth) {
  const nn::Shape shape = tape.shape(level.logits);
  const Index D = truth.displacement.shape().channels();
  const Var targets = tape.make(shape);
  const Var counts = tape.make(shape.without(-1));
  tape.array(targets) = S(0);
  for (Index i = 0; i < shape.rows(); ++i) {
    tape.data(counts)[i] = S(0);
    if (truth.valid[i] == S(0) || truth.visible[i] == S(0)) continue;
    const S* const origin = tape.data(level.origin) + 2 * i;
    const S* const wanted = truth.displacement.data() + D * i;
    const double x = static_cast<double>(wanted[0] - origin[0]) / level.stride;
    const double y = static_cast<double>((D == 2 ? wanted[1] : S(0)) - origin[1]) / level.stride;
    const bool inside = spread(level.window, x, y, tape.data(targets) + i * shape.channels());
    tape.data(counts)[i] = inside ? S(1) : S(0);
  }
  return masked_mean(tape, soft_cross_entropy(tape, level.logits, targets), counts);
}

/// (log sigma, correlation) as the factor of student_t_nll_2d: s_0 = log sx, l = r sy,
/// s_1 = log(sy sqrt(1 - r^2)).
template <typename S>
Var factor_of(nn::Tape<S>& tape, const MatchPrediction& p) {
  const Var log_sx = slice(tape, p.log_sigma, -1, 0, 1);
  const Var log_sy = slice(tape, p.log_sigma, -1, 1, 1);
  const Var rest = shift(tape, scale(tape, square(tape, p.correlation), -1.0), 1.0);
  const Var s1 = add(tape, log_sy, scale(tape, log(tape, rest), 0.5));
  return concat(tape, {log_sx, s1, multiply(tape, p.correlation, exp(tape, log_sy))}, -1);
}

template <typename S>
Var likelihood_loss(nn::Tape<S>& tape,
                    const MatchPrediction& p,
                    const MatchTruth<S>& truth,
                    Var wanted,
                    Var counts) {
  const Var residual = subtract(tape, p.displacement, wanted);
  if (truth.displacement.shape().channels() == 2) {
    const Var each = student_t_nll_2d(tape, residual, factor_of(tape, p), kDegreesOfFreedom);
    return masked_mean(tape, each, counts);
  }
  const Var each = student_t_nll(tape, residual, p.log_sigma, kDegreesOfFreedom);
  return masked_mean(tape, reshape(tape, each, tape.shape(counts)), counts);
}

template <typename S>
Var confidence_loss(nn::Tape<S>& tape,
                    const MatchPrediction& p,
                    const MatchTruth<S>& truth,
                    double confident_error) {
  const nn::Shape shape = truth.valid.shape();
  const Index D = truth.displacement.shape().channels();
  const Var targets = tape.make(shape);
  for (Index i = 0; i < shape.size(); ++i) {
    double square = 0.0;
    for (Index d = i * D; d < (i + 1) * D; ++d) {
      const auto error = static_cast<double>(tape.data(p.displacement)[d] - truth.displacement[d]);
      square += error * error;
    }
    const bool good = truth.visible[i] != S(0) && square < confident_error * confident_error;
    tape.data(targets)[i] = good ? S(1) : S(0);
  }
  const Var each = binary_cross_entropy_with_logits(tape, p.confidence, targets);
  return masked_mean(tape, each, tape.constant(truth.valid));
}

/// The wanted displacements with 0 where nothing is known: NaN times a mask of 0 is NaN.
template <typename S>
Var known_displacement(nn::Tape<S>& tape, const MatchTruth<S>& truth) {
  const Index D = truth.displacement.shape().channels();
  const Var wanted = tape.constant(truth.displacement);
  for (Index i = 0; i < truth.displacement.size(); ++i) {
    if (truth.valid[i / D] == S(0)) tape.data(wanted)[i] = S(0);
  }
  return wanted;
}

}  // namespace

void MatchLossOptions::describe(Config& config) {
  config.field("level_weight", level_weight, "of the cross-entropy of each level");
  config.field("likelihood_weight", likelihood_weight, "of the error under its uncertainty");
  config.field("confidence_weight", confidence_weight, "of the confidence");
  config.field("confident_error", confident_error, "a match that far off is no match [px]");
}

void MatchLossOptions::validate() const {
  require(level_weight >= 0.0, "level_weight", level_weight, ">= 0");
  require(likelihood_weight >= 0.0, "likelihood_weight", likelihood_weight, ">= 0");
  require(confidence_weight >= 0.0, "confidence_weight", confidence_weight, ">= 0");
  require(confident_error > 0.0, "confident_error", confident_error, "> 0");
}

template <typename S>
MatchLoss match_loss(nn::Tape<S>& tape,
                     const NetworkMatch& match,
                     const MatchTruth<S>& truth,
                     const MatchLossOptions& options) {
  const nn::Shape shape = tape.shape(match.prediction.displacement);
  nn::expects_shapes(truth.displacement.shape() == shape, "match_loss: displacement [N,P,D]",
                     truth.displacement.shape(), shape);
  nn::expects_shapes(
      truth.valid.shape() == shape.without(-1) && truth.visible.shape() == shape.without(-1),
      "match_loss: valid and visible [N,P]", truth.valid.shape(), truth.visible.shape());
  const Var wanted = known_displacement(tape, truth);
  const Var seen = multiply(tape, tape.constant(truth.valid), tape.constant(truth.visible));

  MatchLoss loss;
  loss.likelihood = likelihood_loss(tape, match.prediction, truth, wanted, seen);
  loss.confidence = confidence_loss(tape, match.prediction, truth, options.confident_error);
  loss.total = add(tape, scale(tape, loss.likelihood, options.likelihood_weight),
                   scale(tape, loss.confidence, options.confidence_weight));
  for (std::size_t i = 0; i < match.levels.size(); ++i) {
    loss.cross_entropy[i] = level_loss(tape, match.levels[i], truth);
    loss.total = add(tape, loss.total, scale(tape, loss.cross_entropy[i], options.level_weight));
  }
  return loss;
}

template MatchLoss match_loss(nn::Tape<float>&,
                              const NetworkMatch&,
                              const MatchTruth<float>&,
                              const MatchLossOptions&);
template MatchLoss match_loss(nn::Tape<double>&,
                              const NetworkMatch&,
                              const MatchTruth<double>&,
                              const MatchLossOptions&);

}  // namespace imslam::vo

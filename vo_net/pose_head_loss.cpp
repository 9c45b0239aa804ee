#include "vo_net/pose_head_loss.hpp"

#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/layout.hpp"
#include "slam/nn/ops/losses.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/nn/ops/reduce.hpp"

namespace imslam::vo {
namespace {

using nn::Var;

constexpr double kDegreesOfFreedom = 4.0;

template <typename S>
Var rotation_loss(nn::Tape<S>& tape, const PoseHeadOutput& look, const PoseHeadTruth<S>& truth) {
  const Var residual = subtract(tape, look.rotation, tape.constant(truth.rotation));
  const Var each = student_t_nll(tape, residual, look.log_sigma_rotation, kDegreesOfFreedom);
  return scale(tape, mean(tape, each), 3.0);  // the sum over the axes
}

template <typename S>
Var direction_loss(nn::Tape<S>& tape, const PoseHeadOutput& look, const PoseHeadTruth<S>& truth) {
  const Var difference = subtract(tape, look.direction, tape.constant(truth.direction));
  const Var chord_sq = sum(tape, square(tape, difference), {-1}, nn::Axes::kKeep);
  const Var information = exp(tape, scale(tape, look.log_sigma_direction, -2.0));
  const Var whitened = scale(tape, multiply(tape, chord_sq, information), 1.0 / kDegreesOfFreedom);
  const Var each =
      add(tape, scale(tape, look.log_sigma_direction, 2.0),
          scale(tape, log(tape, shift(tape, whitened, 1.0)), 0.5 * (kDegreesOfFreedom + 2.0)));
  return masked_mean(tape, each, tape.constant(truth.moves));
}

}  // namespace

template <typename S>
Var pose_head_loss(nn::Tape<S>& tape,
                   const std::vector<PoseHeadOutput>& looks,
                   const PoseHeadTruth<S>& truth,
                   double early_weight) {
  expects(!looks.empty(), "pose_head_loss: at least one look");
  Var total;
  for (std::size_t k = 0; k < looks.size(); ++k) {
    const Var both =
        add(tape, rotation_loss(tape, looks[k], truth), direction_loss(tape, looks[k], truth));
    const bool last = k + 1 == looks.size();
    const Var weighted = last ? both : scale(tape, both, early_weight);
    total = total ? add(tape, total, weighted) : weighted;
  }
  return total;
}

template Var pose_head_loss(nn::Tape<float>&,
                            const std::vector<PoseHeadOutput>&,
                            const PoseHeadTruth<float>&,
                            double);
template Var pose_head_loss(nn::Tape<double>&,
                            const std::vector<PoseHeadOutput>&,
                            const PoseHeadTruth<double>&,
                            double);

}  // namespace imslam::vo

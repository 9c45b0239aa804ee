#include "slam/training/pretrain_vo.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "slam/nn/ops/arithmetic.hpp"

namespace imslam::training {
namespace {

/// Streams of Random(seed).
enum : std::uint64_t { kWeightStream, kQueryStream, kTeacherStream };

Random stream(const PretrainVoOptions& options, std::uint64_t which) {
  return Random(static_cast<std::uint64_t>(options.seed)).fork(which);
}

const PretrainVoOptions& validated(const PretrainVoOptions& options) {
  options.validate();
  return options;
}

vo::MatchNetwork<float> make_network(const PretrainVoOptions& options) {
  Random random = stream(options, kWeightStream);
  return vo::MatchNetwork<float>(vo::MatchNetworkOptions(), random);
}

nn::ParameterList<float> parameters_of(vo::MatchNetwork<float>& network) {
  nn::ParameterList<float> list;
  network.collect(list);
  return list;
}

/// 0 at the start, 1 after `share` of the steps.
double ramp(int step, int steps, double share) {
  const double end = share * steps;
  return end <= 0.0 ? 1.0 : std::min(1.0, step / end);
}

}  // namespace

PretrainVo::PretrainVo(const PretrainVoOptions& options)
    : NetworkTraining(validated(options), learner::text_of_training(options)),
      options_(options),
      generator_(options.triplets),
      augmentation_(options.augmentation),
      network_(make_network(options)),
      slots_(static_cast<std::size_t>(options.batch)) {
  adopt(parameters_of(network_));
}

nn::Var PretrainVo::sample_loss(nn::Tape<float>& tape, std::size_t slot) {
  const auto index = static_cast<std::uint64_t>(step_count()) * slots_.size() + slot;
  Triplet& triplet = slots_[slot];
  generator_.make(index, triplet);
  augmentation_.apply(index, ramp(step_count(), options_.steps, options_.ramp), triplet);
  const MatchSample sample =
      draw_queries(triplet, options_.queries, stream(options_, kQueryStream).fork(index));
  const double own_chain =
      options_.own_chain * ramp(step_count(), options_.steps, options_.teacher);
  Random chance = stream(options_, kTeacherStream).fork(index);
  const bool teacher = !chance.chance(own_chain);

  const vo::FeaturePyramid features = network_.encode(tape, tape.constant(sample.images));
  const auto loss_of = [&](vo::MatchKind kind, const vo::MatchTruth<float>& truth) {
    const auto match = match_sample(tape, network_, features, sample, kind, teacher);
    return match_loss(tape, match, truth, options_.loss).total;
  };
  return add(tape, loss_of(vo::MatchKind::kFlow, sample.flow),
             loss_of(vo::MatchKind::kStereo, sample.stereo));
}

void PretrainVo::prepare_step() {
  network_.freeze_norms(step_count() >= options_.freeze_norms * options_.steps);
}

ValidationResult PretrainVo::validate() {
  if (!validation_) validation_ = std::make_unique<MatchValidation>(options_);
  return with_average([this] { return validation_->evaluate(network_); });
}

learner::ValidationRecord PretrainVo::look() {
  const ValidationResult result = validate();
  return {result.loss, result.text(), result.row()};
}

std::string PretrainVo::log_columns() const { return ValidationResult::columns(); }

nn::ModelCard PretrainVo::card() const {
  nn::ModelCard card;
  card.what =
      "matching network of imslam's stereo visual odometry: displacement, uncertainty and "
      "confidence of query points, over time and left to right";
  card.data = fmt::format("{} synthetic triplets of {} x {} px made by this program; textures: {}",
                          step_count() * options_.batch, options_.triplets.scene.width,
                          options_.triplets.scene.height, generator_.description());
  card.seed = fmt::format("{}", options_.seed);
  card.metrics = fmt::format("{} validation triplets of other seeds, half of them degraded",
                             options_.validation_samples);
  card.limits =
      "trained on synthetic planar scenes only; flow beyond 80 px from the predicted "
      "displacement and disparities beyond 192 px are not found";
  return card;
}

}  // namespace imslam::training

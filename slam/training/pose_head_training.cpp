#include "slam/training/pose_head_training.hpp"

#include <fmt/format.h>

namespace imslam::training {
namespace {

const PoseHeadTrainingOptions& validated(const PoseHeadTrainingOptions& options) {
  options.validate();
  return options;
}

vo::PoseHead<float> make_network(const PoseHeadTrainingOptions& options) {
  Random random(static_cast<std::uint64_t>(options.seed));
  return {vo::PoseHeadSizes(), random};
}

nn::ParameterList<float> parameters_of(vo::PoseHead<float>& network) {
  nn::ParameterList<float> list;
  network.collect(list);
  return list;
}

}  // namespace

PoseHeadTraining::PoseHeadTraining(const PoseHeadTrainingOptions& options)
    : NetworkTraining(validated(options), learner::text_of_training(options)),
      options_(options),
      generator_(options.flow),
      network_(make_network(options)) {
  adopt(parameters_of(network_));
}

nn::Var PoseHeadTraining::sample_loss(nn::Tape<float>& tape, std::size_t slot) {
  const std::uint64_t index =
      static_cast<std::uint64_t>(step_count()) * static_cast<std::uint64_t>(options_.batch) + slot;
  const auto count = static_cast<std::uint64_t>(options_.fields);
  std::vector<FlowField> fields;
  for (std::uint64_t i = 0; i < count; ++i) fields.push_back(generator_.make(index * count + i));
  const PoseHeadSample sample = pose_head_sample(fields);
  const auto looks = network_.forward(tape, tape.constant(sample.grids));
  return pose_head_loss(tape, looks, sample.truth, options_.early_weight);
}

PoseHeadQuality PoseHeadTraining::validate() {
  if (!validation_) validation_ = std::make_unique<PoseHeadValidation>(options_);
  return with_average([this] { return validation_->evaluate(network_); });
}

learner::ValidationRecord PoseHeadTraining::look() {
  const PoseHeadQuality quality = validate();
  return {quality.loss, quality.text(), quality.row()};
}

nn::ModelCard PoseHeadTraining::card() const {
  nn::ModelCard card;
  card.what =
      "pose head of imslam's stereo visual odometry (vo.head: regression): rotation and direction "
      "of translation, with uncertainties, from a 48 x 32 grid of flow and intrinsics";
  card.data = fmt::format(
      "{} synthetic flow fields made by this program (cameras of 50 to 105 degrees; rooms, "
      "streets, "
      "ground, clutter, relief; noise, outliers, holes, moving things); no images",
      static_cast<std::int64_t>(step_count()) * options_.batch * options_.fields);
  card.seed = fmt::format("{}", options_.seed);
  card.metrics = fmt::format("{} validation fields of other seeds", options_.validation_samples);
  card.limits =
      "trained on synthetic motion fields only; less exact than the geometric head, which stays "
      "the "
      "default; cameras wider than 105 degrees and turns beyond 0.2 rad per step were not seen";
  return card;
}

}  // namespace imslam::training

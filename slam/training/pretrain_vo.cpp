#include "slam/training/pretrain_vo.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/training/schedule.hpp"
#include "slam/nn/weights_io.hpp"

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

/// What the weights depend on: not how often they are looked at.
std::string text_of(PretrainVoOptions options) {
  const PretrainVoOptions defaults;
  options.validation_every = defaults.validation_every;
  options.validation_samples = defaults.validation_samples;
  options.checkpoint_every = defaults.checkpoint_every;
  Config config;
  config.section("train", options);
  return config.to_yaml();
}

nn::Adam<float>::Options adam_options(const PretrainVoOptions& options) {
  nn::Adam<float>::Options adam;
  adam.weight_decay = options.weight_decay;
  return adam;
}

/// 0 at the start, 1 after `share` of the steps.
double ramp(int step, int steps, double share) {
  const double end = share * steps;
  return end <= 0.0 ? 1.0 : std::min(1.0, step / end);
}

}  // namespace

PretrainVo::PretrainVo(const PretrainVoOptions& options)
    : options_(validated(options)),
      options_text_(text_of(options)),
      random_(static_cast<std::uint64_t>(options.seed)),
      generator_(options.triplets),
      augmentation_(options.augmentation),
      network_(make_network(options)),
      parameters_(parameters_of(network_)),
      batch_(parameters_, std::min(options.batch, thread_count())),
      optimizer_(adam_options(options)),
      average_(options.average),
      gradients_(nn::zero_gradients(parameters_)),
      slots_(static_cast<std::size_t>(options.batch)) {}

nn::Var PretrainVo::sample_loss(nn::Tape<float>& tape, std::size_t slot) {
  const auto index = static_cast<std::uint64_t>(step_) * slots_.size() + slot;
  Triplet& triplet = slots_[slot];
  generator_.make(index, triplet);
  augmentation_.apply(index, ramp(step_, options_.steps, options_.ramp), triplet);
  const MatchSample sample =
      draw_queries(triplet, options_.queries, stream(options_, kQueryStream).fork(index));
  const double own_chain = options_.own_chain * ramp(step_, options_.steps, options_.teacher);
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

double PretrainVo::step() {
  network_.freeze_norms(step_ >= options_.freeze_norms * options_.steps);
  const double loss = batch_.run(
      slots_.size(),
      [this](nn::Tape<float>& tape, std::size_t slot) { return sample_loss(tape, slot); },
      gradients_);
  const nn::CosineSchedule schedule{options_.rate, options_.steps, options_.warm_up};
  if (std::isfinite(nn::clip_global_norm(gradients_, options_.clip)) && std::isfinite(loss)) {
    optimizer_.step(parameters_, gradients_, schedule.rate(step_));
    average_.update(parameters_);
  } else {
    ++skipped_;
  }
  ++step_;
  return loss;
}

ValidationResult PretrainVo::validate() {
  if (!validation_) validation_ = std::make_unique<MatchValidation>(options_);
  average_.swap(parameters_);
  ValidationResult result = validation_->evaluate(network_);
  average_.swap(parameters_);
  return result;
}

void PretrainVo::save(const std::filesystem::path& file) {
  nn::WeightsWriter writer;
  for (const nn::Parameter<float>* parameter : parameters_) {
    writer.add("weights/" + parameter->name, parameter->value);
  }
  for (std::size_t i = 0; i < average_.averages().size(); ++i) {
    writer.add("average/" + parameters_[i].name, average_.averages()[i]);
  }
  nn::add_state(writer, "optimizer/", optimizer_.state(parameters_));
  writer.add("step", step_);
  writer.add("skipped", skipped_);
  writer.add("average_updates", average_.updates());
  writer.add("best_loss", nn::Tensor<double>({1}, {best_loss}));
  writer.write(file, {{"options", options_text_}, {"parent", parent_sha256_}});
}

void PretrainVo::restore(const std::filesystem::path& file) {
  const auto checkpoint = nn::WeightsFile::read(file);
  const auto text = checkpoint.metadata().find("options");
  if (text == checkpoint.metadata().end() || text->second != options_text_) {
    throw InputError(file.string() +
                         ": belongs to a training with other options (see config.yaml "
                         "beside it); use those, or another folder",
                     ExitCode::kModel);
  }
  std::vector<nn::Tensor<float>> averages;
  const bool has_average = checkpoint.integer("average_updates") > 0;
  for (nn::Parameter<float>* parameter : parameters_) {
    checkpoint.read_into("weights/" + parameter->name, parameter->value);
    if (!has_average) continue;
    averages.emplace_back(parameter->value.shape());
    checkpoint.read_into("average/" + parameter->name, averages.back());
  }
  average_.restore(checkpoint.integer("average_updates"), std::move(averages));
  optimizer_.restore(parameters_, nn::state_of<float>(checkpoint, "optimizer/"));
  step_ = static_cast<int>(checkpoint.integer("step"));
  skipped_ = static_cast<int>(checkpoint.integer("skipped"));
  nn::Tensor<double> best({1});
  checkpoint.read_into("best_loss", best);
  best_loss = best[0];
  const auto parent = checkpoint.metadata().find("parent");
  if (parent != checkpoint.metadata().end()) parent_sha256_ = parent->second;
}

void PretrainVo::start_from(const std::filesystem::path& weights) {
  const auto file = nn::WeightsFile::read(weights);
  nn::load_parameters(file, parameters_);
  parent_sha256_ = file.data_sha256();
}

void PretrainVo::write_weights(const std::filesystem::path& file, nn::ModelCard card) {
  average_.swap(parameters_);
  card.parent = parent_sha256_;
  nn::save_parameters(file, parameters_, card, nn::NumberType::kF16);
  average_.swap(parameters_);
}

}  // namespace imslam::training

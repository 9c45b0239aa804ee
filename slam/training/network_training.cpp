#include "slam/training/network_training.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/nn/training/schedule.hpp"
#include "slam/nn/weights_io.hpp"

namespace imslam::training {
namespace {

nn::Adam<float>::Options adam_options(const TrainingOptions& options) {
  nn::Adam<float>::Options adam;
  adam.weight_decay = options.weight_decay;
  return adam;
}

}  // namespace

NetworkTraining::NetworkTraining(const TrainingOptions& options, std::string options_text)
    : common_(options),
      options_text_(std::move(options_text)),
      optimizer_(adam_options(options)),
      average_(options.average) {}

void NetworkTraining::adopt(const nn::ParameterList<float>& parameters) {
  parameters_ = parameters;
  batch_.emplace(parameters_, std::min(common_.batch, thread_count()));
  gradients_ = nn::zero_gradients(parameters_);
}

double NetworkTraining::step() {
  prepare_step();
  const double loss = batch_->run(
      static_cast<std::size_t>(common_.batch),
      [this](nn::Tape<float>& tape, std::size_t slot) { return sample_loss(tape, slot); },
      gradients_);
  const nn::CosineSchedule schedule{common_.rate, common_.steps, common_.warm_up};
  if (std::isfinite(nn::clip_global_norm(gradients_, common_.clip)) && std::isfinite(loss)) {
    optimizer_.step(parameters_, gradients_, schedule.rate(step_));
    average_.update(parameters_);
  } else {
    ++skipped_;
  }
  ++step_;
  return loss;
}

void NetworkTraining::save(const std::filesystem::path& file) {
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

void NetworkTraining::restore(const std::filesystem::path& file) {
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

void NetworkTraining::start_from(const std::filesystem::path& weights) {
  const auto file = nn::WeightsFile::read(weights);
  nn::load_parameters(file, parameters_);
  parent_sha256_ = file.data_sha256();
}

void NetworkTraining::write_weights(const std::filesystem::path& file, nn::ModelCard card) {
  average_.swap(parameters_);
  card.parent = parent_sha256_;
  nn::save_parameters(file, parameters_, card, nn::NumberType::kF16);
  average_.swap(parameters_);
}

}  // namespace imslam::training

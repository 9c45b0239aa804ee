#include "slam/learner/network_training.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/base/text.hpp"
#include "slam/learner/shared_batch.hpp"
#include "slam/nn/training/schedule.hpp"

namespace imslam::learner {
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

void NetworkTraining::share_batches(ProcessGroup& group, std::size_t parts) {
  group_ = &group;
  parts_ = parts;
}

double NetworkTraining::run_batch() {
  const auto samples = static_cast<std::size_t>(common_.batch);
  const auto loss = [this](nn::Tape<float>& tape, std::size_t slot) {
    return sample_loss(tape, slot);
  };
  if (group_ == nullptr) return batch_->run(samples, loss, gradients_);
  return shared_batch(*group_, *batch_, samples, parts_, loss, gradients_);
}

double NetworkTraining::step() {
  prepare_step();
  double loss = run_batch();
  const bool any_used = scale_to_used_samples(loss);
  const nn::CosineSchedule schedule{common_.rate, common_.steps, common_.warm_up};
  record_.loss = loss;
  record_.rate = schedule.rate(step_);
  record_.gradient_norm = nn::clip_network_norms(parameters_, gradients_, common_.clip);
  if (!any_used) {
    ++skipped_.unsolved;
  } else if (!std::isfinite(record_.gradient_norm) || !std::isfinite(loss)) {
    ++skipped_.not_finite;
  } else {
    optimizer_.step(parameters_, gradients_, record_.rate);
    average_.update(parameters_);
  }
  finish_step();
  ++step_;
  return loss;
}

/// Refused samples count 0 in the sums: loss and gradients become means over the others.
bool NetworkTraining::scale_to_used_samples(double& loss) {
  const BatchTally seen = group_ == nullptr ? tally() : shared_tally(*group_, tally());
  record_.residual = seen.residual;
  const std::int64_t refused = seen.refused_samples();
  if (refused == 0) return true;
  for (std::size_t i = 0; i < seen.refused.size(); ++i) skipped_.samples[i] += seen.refused[i];
  const std::int64_t used = common_.batch - refused;
  if (used <= 0) return false;
  const double share = static_cast<double>(common_.batch) / static_cast<double>(used);
  loss *= share;
  for (nn::Tensor<float>& gradient : gradients_) gradient.array() *= static_cast<float>(share);
  return true;
}

bool NetworkTraining::note_look(double loss) {
  const bool gain = loss < best_loss_;
  looks_without_gain_ = gain ? 0 : looks_without_gain_ + 1;
  if (gain) best_loss_ = loss;
  return gain;
}

void NetworkTraining::note_start(double loss) {
  start_loss_ = loss;
  note_look(loss);
}

void NetworkTraining::swap_average() {
  if (average_.updates() > 0) average_.swap(parameters_);
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
  writer.add("average_updates", average_.updates());
  writer.add("best_loss", nn::Tensor<double>({1}, {best_loss_}));
  save_counts(writer);
  save_more(writer);
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
  nn::Tensor<double> best({1});
  checkpoint.read_into("best_loss", best);
  best_loss_ = best[0];
  restore_counts(checkpoint);
  const auto parent = checkpoint.metadata().find("parent");
  if (parent != checkpoint.metadata().end()) parent_sha256_ = parent->second;
  restore_more(checkpoint);
}

void NetworkTraining::save_counts(nn::WeightsWriter& writer) const {
  writer.add("skipped", skipped_.steps());
  writer.add("skipped_unsolved", skipped_.unsolved);
  for (std::size_t i = 0; i < skipped_.samples.size(); ++i) {
    writer.add("refused/" + std::to_string(i), skipped_.samples[i]);
  }
  writer.add("looks_without_gain", looks_without_gain_);
  if (start_loss_) writer.add("start_loss", nn::Tensor<double>({1}, {*start_loss_}));
}

/// All but "skipped" came later: checkpoints of before have nothing to count.
void NetworkTraining::restore_counts(const nn::WeightsFile& checkpoint) {
  const auto count = [&](const std::string& name) {
    return checkpoint.find(name) != nullptr ? checkpoint.integer(name) : 0;
  };
  skipped_.unsolved = static_cast<int>(count("skipped_unsolved"));
  skipped_.not_finite = static_cast<int>(count("skipped")) - skipped_.unsolved;
  for (std::size_t i = 0; i < skipped_.samples.size(); ++i) {
    skipped_.samples[i] = count("refused/" + std::to_string(i));
  }
  looks_without_gain_ = static_cast<int>(count("looks_without_gain"));
  if (checkpoint.find("start_loss") == nullptr) return;
  nn::Tensor<double> start({1});
  checkpoint.read_into("start_loss", start);
  start_loss_ = start[0];
}

void NetworkTraining::start_from(const std::filesystem::path& weights) {
  const auto file = nn::WeightsFile::read(weights);
  nn::load_parameters(file, parameters_);
  parent_sha256_ = file.data_sha256();
}

void NetworkTraining::write_weights(const std::filesystem::path& file, nn::ModelCard card) {
  swap_average();
  card.parent = parent_sha256_;
  nn::save_parameters(file, parameters_, card, nn::NumberType::kF16);
  swap_average();
}

std::string without_stop_keys(const std::string& yaml) {
  std::string kept;
  for (const std::string_view line : split(yaml, '\n')) {
    const std::string_view key = trim(line.substr(0, line.find(':')));
    if (key != "patience" && key != "guard") kept += std::string(line) + '\n';
  }
  kept.pop_back();  // split() sees an empty line behind the last
  return kept;
}

}  // namespace imslam::learner

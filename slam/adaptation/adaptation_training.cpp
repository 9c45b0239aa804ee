#include "slam/adaptation/adaptation_training.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "slam/adaptation/device_agreement.hpp"
#include "slam/base/error.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/system/known_device.hpp"

namespace imslam::adaptation {
namespace {

/// Of so many sequences.
AdaptationOptions completed(const AdaptationOptions& options, std::size_t sequences) {
  options.validate();
  AdaptationOptions all = options.completed();
  all.batch *= static_cast<int>(sequences);
  return all;
}

/// What the weights depend on.
std::string text_of(const std::vector<EpochRequest>& requests, const std::string& data_sha256) {
  const EpochRequest& request = requests.front();
  Config config;
  system::SlamOptions slam = request.slam;
  slam.describe(config);
  return learner::text_of_training(request.options) + config.to_yaml() +
         fmt::format("frames: {}:{}\ndata: {}\n", request.run.first_frame, request.run.last_frame,
                     data_sha256);
}

std::vector<DeviceCalibration> devices_of(const std::vector<EpochRequest>& requests) {
  std::vector<DeviceCalibration> devices;
  for (const EpochRequest& request : requests) {
    devices.push_back(system::present_device(request.slam, request.sequence));
  }
  return devices;
}

std::string names_of(const std::vector<EpochRequest>& requests) {
  std::string names;
  for (const EpochRequest& request : requests) {
    names += (names.empty() ? "" : ", ") + request.name();
  }
  return names;
}

}  // namespace

AdaptationTraining::AdaptationTraining(const std::vector<EpochRequest>& requests,
                                       const std::string& data_sha256,
                                       ProcessGroup& group)
    : NetworkTraining(completed(requests.front().options, requests.size()),
                      text_of(requests, data_sha256)),
      requests_(requests),
      data_sha256_(data_sha256),
      group_(group),
      networks_(
          requests.front().slam, options(), distinct_devices(devices_of(requests), devices_)) {
  if (group.size() > 1 && networks_.match() != nullptr) {
    throw InputError(
        "finetune.matcher: the matching network's running statistics belong to one process; "
        "leave it off, or use one process",
        ExitCode::kUsage);
  }
  if (requests.size() > 1 || group.size() > 1) share_batches(group, requests.size());
  for (std::size_t s = 0; s < requests.size(); ++s) {
    lessons_.push_back(nullptr);
    if (!group.owns(s)) continue;
    lessons_[s] = std::make_unique<SequenceLessons>(requests_[s], networks_, devices_[s]);
  }
  given_weights_ = present_weights();
  adopt(networks_.parameters());
}

std::vector<nn::Tensor<float>> AdaptationTraining::present_weights() const {
  std::vector<nn::Tensor<float>> weights;
  for (const nn::Parameter<float>* parameter : networks_.parameters()) {
    weights.push_back(parameter->value.clone());
  }
  return weights;
}

void AdaptationTraining::with_weights(std::vector<nn::Tensor<float>>& weights,
                                      const std::function<void()>& act) {
  const auto swap_weights = [&] {
    for (std::size_t i = 0; i < weights.size(); ++i) {
      std::swap(networks_.parameters()[i].value, weights[i]);
    }
  };
  swap_weights();
  act();
  swap_weights();
}

void AdaptationTraining::run_sequences(int first_step) {
  bool stopped = false;
  for (const auto& lessons : lessons_) {
    if (!lessons || stopped) continue;
    try {
      // Networks that were given must see something.
      lessons->run(first_step / steps_per_epoch(), first_step == 0);
    } catch (const InputError& problem) {
      if (problem.code() != ExitCode::kInterrupted) throw;
      stopped = true;
    }
  }
  if (!group_.any(stopped)) return;
  throw InputError("stopped in the middle of an epoch; --resume goes on", ExitCode::kInterrupted);
}

/// After a resume: the matches of all epochs are those that the given networks asked for.
void AdaptationTraining::recall_first_matches() {
  const bool lacking = std::any_of(lessons_.begin(), lessons_.end(), [](const auto& lessons) {
    return lessons && !lessons->has_matches();
  });
  if (group_.any(lacking)) with_weights(given_weights_, [this] { run_sequences(0); });
}

void AdaptationTraining::begin_epoch(int first_step) {
  if (first_step > 0) recall_first_matches();
  epoch_weights_ = present_weights();
  run_sequences(first_step);
  epoch_step_ = first_step;
}

void AdaptationTraining::have_runs() {
  const int first_step = step_count() - step_count() % steps_per_epoch();
  if (epoch_step_ == first_step) return;
  if (step_count() == first_step || epoch_weights_.empty()) return begin_epoch(step_count());
  // Resumed in the middle of an epoch: run it again with the weights that it began with.
  std::vector<nn::Tensor<float>> weights = std::move(epoch_weights_);
  with_weights(weights, [&] { begin_epoch(first_step); });
}

void AdaptationTraining::prepare_step() {
  have_runs();
  if (step_count() == epoch_step_) refine_devices();
  for (const auto& lessons : lessons_) {
    if (lessons) lessons->begin_step();
  }
}

/// What the graphs say of the devices counts from the next runs on.
void AdaptationTraining::refine_devices() {
  const auto refined = agreed_devices(group_, devices_, networks_.device_count(),
                                      [&](std::size_t s) { return lessons_[s]->refined_device(); });
  for (std::size_t i = 0; i < refined.size(); ++i) networks_.set_device(refined[i], i);
}

nn::Var AdaptationTraining::sample_loss(nn::Tape<float>& tape, std::size_t slot) {
  const auto slots = static_cast<std::size_t>(options().lessons_per_step());
  return lessons_[slot / slots]->lesson(tape, slot % slots, step_count());
}

learner::BatchTally AdaptationTraining::tally() const {
  learner::BatchTally all;
  for (const auto& lessons : lessons_) {
    if (!lessons) continue;
    const learner::BatchTally one = lessons->tally();
    all.residual = std::max(all.residual, one.residual);
    for (std::size_t i = 0; i < all.refused.size(); ++i) all.refused[i] += one.refused[i];
  }
  return all;
}

learner::ValidationRecord AdaptationTraining::look() {
  return with_average([this] {
    begin_epoch(step_count());
    const auto packed = gather_items(group_, lessons_.size(),
                                     [&](std::size_t s) { return lessons_[s]->scores().packed(); });
    std::vector<EpochScores> all;
    for (const std::string& bytes : packed) all.push_back(EpochScores::unpacked(bytes));
    const std::string mean = group_.rank() == 0 ? mean_of(all).packed() : std::string();
    const EpochScores scores = EpochScores::unpacked(group_.broadcast(mean));
    return learner::ValidationRecord{scores.held_out_loss, scores.text(), scores.row()};
  });
}

void AdaptationTraining::save_more(nn::WeightsWriter& writer) const {
  for (std::size_t i = 0; i < epoch_weights_.size(); ++i) {
    writer.add("epoch/" + networks_.parameters()[i].name, epoch_weights_[i]);
  }
}

void AdaptationTraining::restore_more(const nn::WeightsFile& checkpoint) {
  epoch_step_ = -1;
  epoch_weights_.clear();
  for (const nn::Parameter<float>* parameter : networks_.parameters()) {
    if (checkpoint.find("epoch/" + parameter->name) == nullptr) return;
    epoch_weights_.emplace_back(parameter->value.shape());
    checkpoint.read_into("epoch/" + parameter->name, epoch_weights_.back());
  }
}

nn::ModelCard AdaptationTraining::card() const {
  nn::ModelCard card;
  const bool one = requests_.size() == 1;
  card.what = fmt::format("networks of imslam, taught by the graph{} of {}", one ? "" : "s",
                          one ? "one sequence" : fmt::format("{} sequences", requests_.size()));
  card.data = fmt::format("{} without labels (sha256 of index, calibration and inertial files {})",
                          names_of(requests_), data_sha256_);
  card.seed = fmt::format("{}", options().seed);
  card.metrics =
      fmt::format("after {} of {} epochs", step_count() / steps_per_epoch(), options().epochs);
  card.limits = one ? "fitted to this sequence, its sensors and surroundings"
                    : "fitted to these sequences, their sensors and surroundings";
  return card;
}

}  // namespace imslam::adaptation

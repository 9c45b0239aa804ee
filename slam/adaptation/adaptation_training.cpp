#include "slam/adaptation/adaptation_training.hpp"

#include <fmt/format.h>

#include "slam/adaptation/device_refinement.hpp"
#include "slam/adaptation/inertial_lesson.hpp"
#include "slam/adaptation/visual_lesson.hpp"
#include "slam/base/error.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/system/known_device.hpp"

namespace imslam::adaptation {
namespace {

using nn::Var;

AdaptationOptions validated(const AdaptationOptions& options) {
  options.validate();
  return options.completed();
}

/// What the weights depend on.
std::string text_of(const EpochRequest& request, const std::string& data_sha256) {
  Config config;
  system::SlamOptions slam = request.slam;
  slam.describe(config);
  return learner::text_of_training(request.options) + config.to_yaml() +
         fmt::format("frames: {}:{}\ndata: {}\n", request.run.first_frame, request.run.last_frame,
                     data_sha256);
}

}  // namespace

AdaptationTraining::AdaptationTraining(const EpochRequest& request, const std::string& data_sha256)
    : NetworkTraining(validated(request.options), text_of(request, data_sha256)),
      request_(request),
      data_sha256_(data_sha256),
      networks_(
          request.slam, request.options, system::present_device(request.slam, request.sequence)),
      usable_(static_cast<std::size_t>(common_options().batch), 0) {
  adopt(networks_.parameters());
}

void AdaptationTraining::begin_epoch(int first_step) {
  epoch_weights_.clear();
  for (const nn::Parameter<float>* parameter : networks_.parameters()) {
    epoch_weights_.push_back(parameter->value.clone());
  }
  try {
    epoch_ = run_epoch(request_, networks_, first_step / steps_per_epoch());
  } catch (const InputError& problem) {
    // Networks that see no motion at all are the worst, and teach nothing; those that were given
    // must see something.
    if (problem.code() != ExitCode::kTrackingLost || first_step == 0) throw;
    epoch_ = std::make_unique<Epoch>();
    epoch_->reason = problem.what();
  }
  epoch_step_ = first_step;
  if (!truth_) truth_ = true_inertial_log(request_.sequence, epoch_->outcome);
}

const Epoch& AdaptationTraining::epoch() {
  const int first_step = step_count() - step_count() % steps_per_epoch();
  if (epoch_ && epoch_step_ == first_step) return *epoch_;
  if (step_count() == first_step || epoch_weights_.empty()) {
    begin_epoch(step_count());
    return *epoch_;
  }
  // Resumed in the middle of an epoch: run it again with the weights that it began with.
  const auto swap_weights = [&] {
    for (std::size_t i = 0; i < epoch_weights_.size(); ++i) {
      std::swap(networks_.parameters()[i].value, epoch_weights_[i]);
    }
  };
  swap_weights();
  std::vector<nn::Tensor<float>> now = std::move(epoch_weights_);
  begin_epoch(first_step);
  for (std::size_t i = 0; i < now.size(); ++i) networks_.parameters()[i].value = now[i];
  return *epoch_;
}

void AdaptationTraining::prepare_step() {
  epoch();
  if (step_count() == epoch_step_) refine_device();
  std::fill(usable_.begin(), usable_.end(), 0);
}

/// What the graph says of the device counts from the next run on.
void AdaptationTraining::refine_device() {
  const auto& result = epoch_->outcome.result;
  if (!epoch_->teacher) return;
  std::optional<ImuNoise> imu;
  if (request_.sequence.imu()) imu = request_.sequence.imu()->noise;
  networks_.set_device(refined_device(result, epoch_->device, request_.sequence.camera(), imu,
                                      request_.slam.system, request_.options));
}

bool AdaptationTraining::teaches(std::size_t slot) const {
  if (!epoch_->teacher) return false;
  if (slot != inertial_slot()) return !epoch_->traces.empty();
  return networks_.imu_network() != nullptr && epoch_->log.truth.size() >= 2;
}

Var AdaptationTraining::sample_loss(nn::Tape<float>& tape, std::size_t slot) {
  const Var nothing = tape.constant(nn::Tensor<float>({1}));
  if (!teaches(slot)) return nothing;
  const AdaptationOptions& options = request_.options;
  const auto step = static_cast<std::size_t>(step_count() % steps_per_epoch());
  if (slot == inertial_slot()) {
    const InertialClass of{*networks_.imu_network(),
                           *epoch_->teacher,
                           epoch_->log,
                           request_.slam,
                           options,
                           [&](std::size_t state) { return !is_held_out(state, options); }};
    const Random random = Random(static_cast<std::uint64_t>(options.seed) + 1)
                              .fork(static_cast<std::uint64_t>(step_count()));
    usable_[slot] = 1;
    return scale(tape, inertial_lesson(tape, of, random), options.imu_weight * options.edges);
  }
  const std::size_t place = step * static_cast<std::size_t>(options.edges) + slot;
  const MotionTrace& trace = epoch_->traces[place % epoch_->traces.size()];
  const VisualClass of{networks_, *epoch_->teacher, epoch_->camera, request_.slam.vo, options};
  bool usable = false;
  const Var lesson = visual_lesson(tape, trace, of, usable);
  usable_[slot] = usable ? 1 : 0;
  return usable ? lesson : nothing;
}

learner::BatchTally AdaptationTraining::tally() const {
  learner::BatchTally tally;
  tally.residual = epoch_->outcome.result.solve.gradient_norm;
  for (std::size_t slot = 0; slot < usable_.size(); ++slot) {
    if (usable_[slot] != 0) continue;
    const bool idle = slot == inertial_slot() && networks_.imu_network() == nullptr;
    if (!idle) ++tally.refused[static_cast<std::size_t>(learner::Refusal::kUnconverged)];
  }
  return tally;
}

learner::ValidationRecord AdaptationTraining::look() {
  return with_average([this] {
    begin_epoch(step_count());
    const EpochScores scores = score_epoch(*epoch_, request_.options, truth_ ? &*truth_ : nullptr,
                                           networks_.imu_network());
    return learner::ValidationRecord{scores.held_out_loss, scores.text(), scores.row()};
  });
}

void AdaptationTraining::save_more(nn::WeightsWriter& writer) const {
  for (std::size_t i = 0; i < epoch_weights_.size(); ++i) {
    writer.add("epoch/" + networks_.parameters()[i].name, epoch_weights_[i]);
  }
}

void AdaptationTraining::restore_more(const nn::WeightsFile& checkpoint) {
  epoch_.reset();
  epoch_weights_.clear();
  for (const nn::Parameter<float>* parameter : networks_.parameters()) {
    if (checkpoint.find("epoch/" + parameter->name) == nullptr) return;
    epoch_weights_.emplace_back(parameter->value.shape());
    checkpoint.read_into("epoch/" + parameter->name, epoch_weights_.back());
  }
}

nn::ModelCard AdaptationTraining::card() const {
  nn::ModelCard card;
  card.what = "networks of imslam, taught by the graph of one sequence";
  card.data =
      fmt::format("{} without labels (sha256 of its index, calibration and inertial files {})",
                  request_.sequence.name(), data_sha256_);
  card.seed = fmt::format("{}", request_.options.seed);
  card.metrics = fmt::format("after {} of {} epochs", step_count() / steps_per_epoch(),
                             request_.options.epochs);
  card.limits = "fitted to this sequence, its sensors and surroundings";
  return card;
}

}  // namespace imslam::adaptation

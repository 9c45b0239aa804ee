#include "slam/adaptation/sequence_lessons.hpp"

#include <algorithm>

#include "slam/adaptation/device_refinement.hpp"
#include "slam/adaptation/inertial_lesson.hpp"
#include "slam/adaptation/rehearsal.hpp"
#include "slam/adaptation/visual_lesson.hpp"
#include "slam/base/error.hpp"
#include "slam/nn/ops/pointwise.hpp"

namespace imslam::adaptation {

using nn::Var;

SequenceLessons::SequenceLessons(const EpochRequest& request,
                                 LearnedNetworks& networks,
                                 std::size_t device)
    : request_(request),
      networks_(networks),
      device_(device),
      simulated_(rehearsal_logs(request.options.seed)),
      usable_(static_cast<std::size_t>(request.options.lessons_per_step()), 0) {
  const bool frozen = networks.match() == nullptr;
  if (frozen && request.options.recall_matches) matches_ = std::make_shared<vo::MatchRecording>();
}

void SequenceLessons::run(int number, bool must_see) {
  try {
    epoch_ = run_epoch(request_, networks_, networks_.device(device_), number, matches_);
  } catch (const InputError& problem) {
    if (problem.code() != ExitCode::kTrackingLost || must_see) throw;
    epoch_ = std::make_unique<Epoch>();
    epoch_->reason = problem.what();
  }
  if (!truth_) truth_ = true_inertial_log(request_.sequence, epoch_->outcome);
}

EpochScores SequenceLessons::scores() {
  return score_epoch(*epoch_, request_.options, truth_ ? &*truth_ : nullptr,
                     networks_.imu_network());
}

DeviceCalibration SequenceLessons::refined_device() const {
  const auto& result = epoch_->outcome.result;
  if (!epoch_->teacher) return networks_.device(device_);
  std::optional<ImuNoise> imu;
  if (request_.sequence.imu()) imu = request_.sequence.imu()->noise;
  return adaptation::refined_device(result, epoch_->device, imu, request_.slam, request_.options);
}

void SequenceLessons::begin_step() { std::fill(usable_.begin(), usable_.end(), 0); }

bool SequenceLessons::teaches(std::size_t slot) const {
  if (!epoch_->teacher) return false;
  if (!is_inertial(slot)) return !epoch_->traces.empty();
  return networks_.imu_network() != nullptr && epoch_->log.truth.size() >= 2;
}

Var SequenceLessons::inertial(nn::Tape<float>& tape, int step) const {
  const AdaptationOptions& options = request_.options;
  const InertialClass of{*networks_.imu_network(),
                         *epoch_->teacher,
                         epoch_->log,
                         request_.slam,
                         options,
                         [&](std::size_t state) { return !is_held_out(state, options); }};
  const Random random =
      Random(static_cast<std::uint64_t>(options.seed) + 1).fork(static_cast<std::uint64_t>(step));
  return scale(tape, inertial_lesson(tape, of, random), options.imu_weight * options.edges);
}

Var SequenceLessons::rehearse(nn::Tape<float>& tape, std::size_t slot, int step) const {
  const AdaptationOptions& options = request_.options;
  const std::uint64_t index =
      static_cast<std::uint64_t>(step) * static_cast<std::uint64_t>(options.rehearsals) +
      (slot - inertial_slot() - 1);
  const double share = options.rehearsal_weight * options.imu_weight * options.edges /
                       static_cast<double>(options.rehearsals);
  return scale(tape, rehearsal(tape, *networks_.imu_network(), simulated_, index), share);
}

Var SequenceLessons::visual(nn::Tape<float>& tape, std::size_t slot, int step, bool& usable) const {
  const AdaptationOptions& options = request_.options;
  const auto step_of_epoch = static_cast<std::size_t>(step % options.steps_per_epoch);
  const std::size_t place = step_of_epoch * static_cast<std::size_t>(options.edges) + slot;
  const MotionTrace& trace = epoch_->traces[place % epoch_->traces.size()];
  const VisualClass of{networks_, *epoch_->teacher, epoch_->camera, request_.slam.vo, options};
  return visual_lesson(tape, trace, of, usable);
}

Var SequenceLessons::lesson(nn::Tape<float>& tape, std::size_t slot, int step) {
  const Var nothing = tape.constant(nn::Tensor<float>({1}));
  if (!teaches(slot)) return nothing;
  bool usable = true;
  const Var said = slot == inertial_slot() ? inertial(tape, step)
                   : is_inertial(slot)     ? rehearse(tape, slot, step)
                                           : visual(tape, slot, step, usable);
  usable_[slot] = usable ? 1 : 0;
  return usable ? said : nothing;
}

learner::BatchTally SequenceLessons::tally() const {
  learner::BatchTally tally;
  tally.residual = epoch_->outcome.result.solve.gradient_norm;
  for (std::size_t slot = 0; slot < usable_.size(); ++slot) {
    if (usable_[slot] != 0) continue;
    const bool idle = is_inertial(slot) && networks_.imu_network() == nullptr;
    if (!idle) ++tally.refused[static_cast<std::size_t>(learner::Refusal::kUnconverged)];
  }
  return tally;
}

}  // namespace imslam::adaptation

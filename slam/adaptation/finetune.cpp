#include "slam/adaptation/finetune.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "slam/adaptation/device_agreement.hpp"
#include "slam/base/file.hpp"
#include "slam/base/packed_strings.hpp"
#include "slam/nn/weights_io.hpp"
#include "slam/system/known_device.hpp"

namespace imslam::adaptation {
namespace fs = std::filesystem;
namespace {

constexpr const char* kBefore = "before.safetensors";
constexpr const char* kWeights = "weights";

struct Scored {
  system::RunOutcome outcome;
  EpochScores scores;
};

/// A plain run with the networks that the options name, scored like an epoch.
Scored run_and_score(const EpochRequest& request, const system::SlamOptions& slam) {
  AdaptationOptions nothing = request.options;
  nothing.steps_per_epoch = 0;  // no motions are traced
  const LearnedNetworks networks(slam, nothing, {system::present_device(slam, request.sequence)});
  EpochRequest plain{request.sequence, slam, nothing, request.run};
  auto epoch = run_epoch(plain, networks, networks.device(), 0);
  const auto truth = true_inertial_log(request.sequence, epoch->outcome);
  Scored scored;
  scored.scores =
      score_epoch(*epoch, request.options, truth ? &*truth : nullptr, networks.imu_network());
  scored.outcome = std::move(epoch->outcome);
  return scored;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw InputError(folder.string() + ": cannot be made: " + error.message(), ExitCode::kOutput);
  }
}

/// What a finished fine-tuning left: none of it belongs to the one that begins. Without a word that
/// it may go, it stays.
void throw_results_away(const learner::TrainingRequest& request) {
  std::error_code ignored;
  for (const char* name :
       {kWeights, "zero_shot", "adapted", "metrics.json", "report.html", "learning.svg"}) {
    const fs::path result = request.folder / name;
    if (!request.force && fs::exists(result, ignored)) {
      throw InputError(result.string() + ": is in the way, and no training here goes on; " +
                           request.force_flag + " throws it away",
                       ExitCode::kOutput);
    }
    fs::remove_all(result, ignored);
  }
}

/// Whether `file` holds exactly these parameters.
bool holds(const fs::path& file, const nn::ParameterList<float>& parameters) {
  const auto saved = nn::WeightsFile::read(file);
  for (const nn::Parameter<float>* parameter : parameters) {
    if (saved.find(parameter->name) == nullptr) return false;
    nn::Tensor<float> value(parameter->value.shape());
    saved.read_into(parameter->name, value);
    if (!(value.array() == parameter->value.array()).all()) return false;
  }
  return true;
}

/// Leaves the given weights in `folder`/before.safetensors, or makes sure that they are those that
/// the fine-tuning there began with.
void keep_given_weights(AdaptationTraining& training, const learner::TrainingRequest& request) {
  learner::prepare_training_folder(request, training.name());
  const nn::ParameterList<float>& given = training.networks().parameters();
  if (!request.resume || !learner::has_checkpoint(request.folder)) {
    throw_results_away(request);
    nn::save_parameters(request.start, given, training.card());
    return;
  }
  if (!fs::exists(request.start) || !holds(request.start, given)) {
    throw InputError(request.start.string() +
                         ": not the networks that are given now; go on with those it began with, "
                         "or name another --out",
                     ExitCode::kModel);
  }
}

/// Both runs, one after the other.
FinetunedSequence compare(const EpochRequest& request,
                          const fs::path& weights,
                          std::size_t index,
                          const TakeRun& take_run) {
  FinetunedSequence sequence;
  sequence.name = request.name();
  Scored before = run_and_score(request, request.slam);
  sequence.before = before.scores;
  sequence.device_before = before.outcome.result.device;
  if (take_run) take_run(index, FinetuneRun::kZeroShot, before.outcome);
  before = {};
  system::SlamOptions adapted = request.slam;
  use_networks(weights, adapted);
  Scored after = run_and_score(request, adapted);
  sequence.after = after.scores;
  sequence.device_after = after.outcome.result.device;
  sequence.frames = after.outcome.result.graph.size();
  if (take_run) take_run(index, FinetuneRun::kAdapted, after.outcome);
  return sequence;
}

std::string packed_sequence(const FinetunedSequence& sequence) {
  return pack_strings({sequence.name, std::to_string(sequence.frames), sequence.before.packed(),
                       sequence.after.packed(), packed(sequence.device_before),
                       packed(sequence.device_after)});
}

FinetunedSequence unpacked_sequence(const std::string& bytes) {
  const auto parts = unpack_strings(bytes);
  FinetunedSequence sequence;
  sequence.name = parts.at(0);
  sequence.frames = std::stoull(parts.at(1));
  sequence.before = EpochScores::unpacked(parts.at(2));
  sequence.after = EpochScores::unpacked(parts.at(3));
  sequence.device_before = unpacked_device(parts.at(4));
  sequence.device_after = unpacked_device(parts.at(5));
  return sequence;
}

/// Rank 0 writes and speaks; all go on as long as all want to.
void take_part(ProcessGroup& group, learner::TrainingRequest& request) {
  if (group.rank() != 0) request.writes = false;
  if (group.rank() != 0) request.tell = nullptr;
  const auto own = request.keep_going;
  request.keep_going = [own, &group](int done, int steps, const std::string& note) {
    return !group.any(own && !own(done, steps, note));
  };
}

std::vector<fs::path> write_result(AdaptationTraining& training,
                                   const learner::TrainingOutcome& outcome,
                                   const learner::TrainingRequest& request) {
  nn::ModelCard card = nn::WeightsFile::read(outcome.weights).card();
  card.command = request.command;
  make_folder(request.folder / kWeights);
  return training.networks().write(outcome.weights, request.folder / kWeights, card);
}

/// Without frames to judge by nothing could be told from a gain.
void expect_held_out_frames(const EpochRequest& request) {
  if (!request.options.guard) return;
  const std::size_t last =
      request.run.last_frame == 0 ? request.sequence.frame_count() : request.run.last_frame;
  const std::size_t count = last - std::min(last, request.run.first_frame);
  for (std::size_t frame = 0; frame < count; ++frame) {
    if (is_held_out(frame, request.options)) return;
  }
  throw InputError(
      fmt::format("{}: {} frames are too few to hold any out; take more, or hold out "
                  "shorter stretches: --set finetune.stretch={}",
                  request.name(), count, std::max<std::size_t>(2, count / 10)));
}

}  // namespace

std::string sequence_sha256(const datasets::Sequence& sequence) {
  std::string all;
  for (const fs::path& file : sequence.input_files()) {
    all += file.filename().string() + ' ' + sha256_of_file(file) + '\n';
  }
  return sha256(all);
}

std::string data_sha256(const std::vector<EpochRequest>& sequences) {
  if (sequences.size() == 1) return sequence_sha256(sequences[0].sequence);
  std::string all;
  for (const EpochRequest& request : sequences) {
    all += request.name() + ' ' + sequence_sha256(request.sequence) + '\n';
  }
  return sha256(all);
}

EpochScores FinetuneOutcome::before() const {
  std::vector<EpochScores> all;
  for (const FinetunedSequence& one : sequences) all.push_back(one.before);
  return mean_of(all);
}

EpochScores FinetuneOutcome::after() const {
  std::vector<EpochScores> all;
  for (const FinetunedSequence& one : sequences) all.push_back(one.after);
  return mean_of(all);
}

FinetuneOutcome finetune(const std::vector<EpochRequest>& sequences,
                         const std::string& config_yaml,
                         learner::TrainingRequest request,
                         ProcessGroup& group,
                         const TakeRun& take_run) {
  for (const EpochRequest& sequence : sequences) expect_held_out_frames(sequence);
  AdaptationTraining training(sequences, data_sha256(sequences), group);
  request.start = request.folder / kBefore;
  take_part(group, request);
  if (request.writes) keep_given_weights(training, request);
  group.barrier();
  FinetuneOutcome outcome;
  outcome.training = learner::run_training(training, config_yaml, request);
  if (outcome.training.stopped) return outcome;

  if (request.writes) outcome.weights = write_result(training, outcome.training, request);
  group.barrier();
  const auto compared = gather_items(group, sequences.size(), [&](std::size_t s) {
    return packed_sequence(compare(sequences[s], request.folder / kWeights, s, take_run));
  });
  for (const std::string& bytes : compared) outcome.sequences.push_back(unpacked_sequence(bytes));
  return outcome;
}

}  // namespace imslam::adaptation

#include "slam/adaptation/finetune.hpp"

#include <fmt/format.h>

#include <array>
#include <tuple>

#include "slam/base/file.hpp"
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

/// What a finished fine-tuning left: none of it belongs to the one that begins.
void throw_results_away(const fs::path& folder) {
  std::error_code ignored;
  for (const char* name :
       {kWeights, "zero_shot", "adapted", "metrics.json", "report.html", "learning.svg"}) {
    fs::remove_all(folder / name, ignored);
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
    throw_results_away(request.folder);
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

std::string cell(const std::optional<double>& value) {
  return value ? fmt::format("{:.5g}", *value) : "-";
}

std::string change(const std::optional<double>& before, const std::optional<double>& after) {
  if (!before || !after || *before == 0.0) return "-";
  return fmt::format("{:+.1f} %", 100.0 * (*after - *before) / std::abs(*before));
}

}  // namespace

std::string sequence_sha256(const datasets::Sequence& sequence) {
  std::string all;
  for (const fs::path& file : sequence.input_files()) {
    all += file.filename().string() + ' ' + sha256_of_file(file) + '\n';
  }
  return sha256(all);
}

FinetuneOutcome finetune(const EpochRequest& epoch,
                         const std::string& config_yaml,
                         learner::TrainingRequest request) {
  const auto alone = single_process();
  AdaptationTraining training({epoch}, sequence_sha256(epoch.sequence), *alone);
  request.start = request.folder / kBefore;
  keep_given_weights(training, request);
  FinetuneOutcome outcome;
  outcome.training = learner::run_training(training, config_yaml, request);
  if (outcome.training.stopped) return outcome;

  nn::ModelCard card = nn::WeightsFile::read(outcome.training.weights).card();
  card.command = request.command;
  make_folder(request.folder / kWeights);
  outcome.weights =
      training.networks().write(outcome.training.weights, request.folder / kWeights, card);
  Scored before = run_and_score(epoch, epoch.slam);
  system::SlamOptions adapted = epoch.slam;
  use_networks(request.folder / kWeights, adapted);
  Scored after = run_and_score(epoch, adapted);
  outcome.before = before.scores;
  outcome.after = after.scores;
  outcome.zero_shot = std::move(before.outcome);
  outcome.adapted = std::move(after.outcome);
  return outcome;
}

std::string comparison_table(const EpochScores& before, const EpochScores& after) {
  struct Row {
    const char* name;
    std::optional<double> before;
    std::optional<double> after;
  };
  const Row rows[] = {
      {"held-out loss (self-supervised)", before.held_out_loss, after.held_out_loss},
      {"VO: ATE [m]", before.vo_ate_m, after.vo_ate_m},
      {"VO: RPE per frame [m]", before.vo_rpe_m, after.vo_rpe_m},
      {"VO: RPE per frame [deg]", before.vo_rpe_deg, after.vo_rpe_deg},
      {"IMU: rotation over 5 s [deg]", before.imu_rotation_deg, after.imu_rotation_deg},
      {"IMU: position over 5 s [m]", before.imu_position_m, after.imu_position_m},
      {"graph: ATE [m]", before.graph_ate_m, after.graph_ate_m},
      {"graph: RPE per frame [m]", before.graph_rpe_m, after.graph_rpe_m},
      {"graph: RPE per frame [deg]", before.graph_rpe_deg, after.graph_rpe_deg},
  };
  std::string text =
      fmt::format("{:<34}{:>12}{:>12}{:>12}\n", "", "zero-shot", "adapted", "change");
  for (const Row& row : rows) {
    const bool loss = &row == rows;  // its zero means nothing
    text += fmt::format(
        "{:<34}{:>12}{:>12}{:>12}\n", row.name, cell(row.before), cell(row.after),
        loss ? fmt::format("{:+.4f}", *row.after - *row.before) : change(row.before, row.after));
  }
  return text;
}

std::string device_table(const DeviceCalibration& before, const DeviceCalibration& after) {
  constexpr double kDegrees = 180.0 / 3.14159265358979323846;
  const auto rotation = [&](const DeviceCalibration& device) {
    return (kDegrees * device.camera_rotation).eval();
  };
  const std::array<std::tuple<const char*, double, double>, 6> rows{
      {{"device: focal length, error [%]", 100.0 * before.focal_error, 100.0 * after.focal_error},
       {"device: disparity offset [px]", before.disparity_offset_px, after.disparity_offset_px},
       {"device: time offset [ms]", 1e3 * before.time_offset_s, 1e3 * after.time_offset_s},
       {"device: camera turned, x [deg]", rotation(before).x(), rotation(after).x()},
       {"device: camera turned, y [deg]", rotation(before).y(), rotation(after).y()},
       {"device: camera turned, z [deg]", rotation(before).z(), rotation(after).z()}}};
  std::string text;
  for (const auto& [name, old, now] : rows) {
    if (old == now) continue;
    text += fmt::format("{:<34}{:>12.4f}{:>12.4f}\n", name, old, now);
  }
  return text;
}

}  // namespace imslam::adaptation

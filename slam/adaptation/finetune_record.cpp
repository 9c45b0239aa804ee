#include "slam/adaptation/finetune_record.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "slam/adaptation/learning_log.hpp"
#include "slam/adaptation/loss_agreement.hpp"
#include "slam/base/file.hpp"
#include "slam/nn/weights_io.hpp"
#include "slam/report/report.hpp"
#include "slam/system/run_recorder.hpp"

namespace imslam::adaptation {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

json number(const std::optional<double>& value) {
  const bool known = value && std::isfinite(*value) && std::abs(*value) < 1e299;
  return known ? json(*value) : json(nullptr);
}

json scores_json(const EpochScores& scores) {
  return {{"held_out_loss", number(scores.held_out_loss)},
          {"learned_loss", number(scores.learned_loss)},
          {"vo_ate_m", number(scores.vo_ate_m)},
          {"vo_rpe_m", number(scores.vo_rpe_m)},
          {"vo_rpe_deg", number(scores.vo_rpe_deg)},
          {"imu_rotation_deg", number(scores.imu_rotation_deg)},
          {"imu_position_m", number(scores.imu_position_m)},
          {"graph_ate_m", number(scores.graph_ate_m)},
          {"graph_rpe_m", number(scores.graph_rpe_m)},
          {"graph_rpe_deg", number(scores.graph_rpe_deg)}};
}

json device_json(const DeviceCalibration& device) {
  return {{"focal_error", device.focal_error},
          {"disparity_offset_px", device.disparity_offset_px},
          {"time_offset_s", device.time_offset_s},
          {"camera_rotation_rad",
           {device.camera_rotation.x(), device.camera_rotation.y(), device.camera_rotation.z()}}};
}

const char* verdict_of(const FinetuneOutcome& outcome) {
  if (!outcome.training.loss_before) return "forced";
  return outcome.training.gained() ? "adapted" : "given";
}

json guard_json(const FinetuneOutcome& outcome) {
  return {{"on", outcome.training.loss_before.has_value()},
          {"gained", outcome.training.gained()},
          {"verdict", verdict_of(outcome)},
          {"text", guard_text(outcome)},
          {"loss_before", number(outcome.training.loss_before)},
          {"loss_after", number(outcome.training.loss_after)}};
}

/// A forced training does not look at the given networks: the zero-shot run has.
void begin_with(const EpochScores& before, LearningLog& log) {
  if (!log.epoch.empty() && log.epoch.front() == 0.0) return;
  log.epoch.insert(log.epoch.begin(), 0.0);
  const json scores = scores_json(before);
  for (auto& [name, values] : log.curves) {
    const json& value = scores.at(name);
    values.insert(values.begin(), value.is_number() ? value.get<double>() : std::nan(""));
  }
}

json sequences_json(const FinetuneOutcome& outcome) {
  json list = json::array();
  for (const FinetunedSequence& one : outcome.sequences) {
    list.push_back({{"name", one.name},
                    {"frames", one.frames},
                    {"zero_shot", scores_json(one.before)},
                    {"batch_adapted", scores_json(one.after)},
                    {"device",
                     {{"fingerprint", one.device_after.device},
                      {"before", device_json(one.device_before)},
                      {"after", device_json(one.device_after)}}}});
  }
  return list;
}

std::size_t frames_of(const FinetuneOutcome& outcome) {
  std::size_t frames = 0;
  for (const FinetunedSequence& one : outcome.sequences) frames += one.frames;
  return frames;
}

json curves_json(const LearningLog& log) {
  json curves = {{"epoch", log.epoch}};
  for (const auto& [name, values] : log.curves) {
    json& column = curves[name] = json::array();
    for (const double value : values) column.push_back(number(value));
  }
  return curves;
}

json agreement_json(const std::vector<LossAgreement>& all) {
  using Verdict = LossAgreement::Verdict;
  json list = json::array();
  for (const LossAgreement& each : all) {
    const char* verdict = each.verdict == Verdict::kAgree     ? "agree"
                          : each.verdict == Verdict::kUnclear ? "unclear"
                                                              : "contradict";
    list.push_back({{"error", each.error},
                    {"name", each.name},
                    {"looks", each.looks},
                    {"rank_correlation", number(each.rank_correlation)},
                    {"verdict", verdict},
                    {"chosen_epoch", each.chosen_epoch},
                    {"chosen_error", each.chosen_error},
                    {"first_error", each.first_error},
                    {"best_epoch", each.best_epoch},
                    {"best_error", each.best_error},
                    {"text", each.sentence()}});
  }
  return list;
}

json weights_json(const std::vector<fs::path>& files, const fs::path& folder) {
  std::vector<system::ModelRecord> models;
  for (const fs::path& file : files) {
    models.push_back({file.stem().string(), file.lexically_relative(folder).generic_string(),
                      nn::WeightsFile::read(file).card()});
  }
  return system::models_json(models);
}

}  // namespace

std::string guard_text(const FinetuneOutcome& outcome) {
  const learner::TrainingOutcome& training = outcome.training;
  if (!training.loss_before) {
    return "Forced: the best of the epochs is the result, whether or not it gains on the given "
           "networks.";
  }
  if (training.gained()) {
    return fmt::format(
        "The adapted networks are the result: they gain on the given ones in the held-out loss "
        "({:.4f} to {:.4f}).",
        *training.loss_before, training.loss_after);
  }
  return "No epoch gained on the given networks in the held-out loss: the given networks are the "
         "result, unchanged.";
}

void record_finetune(const fs::path& folder,
                     const FinetuneOutcome& outcome,
                     const AdaptationOptions& options,
                     const FinetuneProvenance& provenance) {
  LearningLog log = read_learning_log(folder / "log.csv", options.steps_per_epoch);
  begin_with(outcome.before(), log);
  const json metrics = {
      {"kind", "finetune"},
      {"program", provenance.version},
      {"dataset", provenance.dataset},
      {"data_sha256", provenance.data_sha256},
      {"command", provenance.command},
      {"frames", frames_of(outcome)},
      {"epochs",
       {{"wanted", options.epochs}, {"done", outcome.training.steps / options.steps_per_epoch}}},
      {"steps", outcome.training.steps},
      {"skipped_steps", outcome.training.skipped},
      {"left_out", outcome.training.omitted},
      {"guard", guard_json(outcome)},
      {"results",
       {{"zero_shot", scores_json(outcome.before())},
        {"online_adapted", nullptr},
        {"batch_adapted", scores_json(outcome.after())}}},
      {"sequences", sequences_json(outcome)},
      {"curves", curves_json(log)},
      {"agreement", agreement_json(loss_agreement(log))},
      {"models", weights_json(outcome.weights, folder)}};
  constexpr auto kReplace = json::error_handler_t::replace;  // paths may not be UTF-8
  write_file_atomic(folder / "metrics.json", metrics.dump(2, ' ', false, kReplace) + "\n");
  report::write_report(folder);
}

}  // namespace imslam::adaptation

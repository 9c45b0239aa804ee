#include "slam/training/training_run.hpp"

#include <fmt/format.h>

#include <vector>

#include "slam/base/file.hpp"
#include "slam/base/text.hpp"
#include "slam/nn/model_card.hpp"
#include "slam/nn/weights_io.hpp"
#include "slam/training/pretrain_vo.hpp"

namespace imslam::training {
namespace {

namespace fs = std::filesystem;

const char* const kCheckpoint = "checkpoint.safetensors";
const char* const kWeights = "match_network.safetensors";
const char* const kLog = "log.csv";

void prepare_folder(const TrainingRequest& request) {
  std::error_code error;
  const bool used = fs::exists(request.folder / kCheckpoint) || fs::exists(request.folder / kLog);
  if (used && !request.resume && !request.force) {
    throw InputError(request.folder.string() +
                         ": holds a training; --resume goes on with it, "
                         "--force throws it away",
                     ExitCode::kOutput);
  }
  fs::create_directories(request.folder, error);
  if (error) {
    throw InputError(request.folder.string() + ": cannot be made: " + error.message(),
                     ExitCode::kOutput);
  }
  if (request.resume) return;
  for (const char* name : {kCheckpoint, kWeights, kLog}) fs::remove(request.folder / name, error);
}

/// The log as it was at `step`: what was written after the checkpoint will be written again.
std::vector<std::string> read_log(const fs::path& file, int step) {
  std::vector<std::string> rows;
  if (!fs::exists(file)) return rows;
  const std::string text = read_file(file);
  for (const std::string_view line : split(text, '\n')) {
    const auto number = parse_int64(split(line, ',').front());
    if (number && *number <= step) rows.emplace_back(line);
  }
  return rows;
}

void write_log(const fs::path& file, const std::vector<std::string>& rows) {
  std::string text = "step,samples,loss";
  for (const char* name : ValidationResult::names()) {
    for (const char* figure :
         {"median_px", "outliers_percent", "confident_percent", "confident_median_px",
          "confident_outliers_percent", "normalised_median"}) {
      text += fmt::format(",{}_{}", name, figure);
    }
  }
  text += '\n';
  for (const std::string& row : rows) text += row + '\n';
  write_file_atomic(file, text);
}

std::string log_row(int step, int batch, const ValidationResult& v) {
  std::string row = fmt::format("{},{},{:.6f}", step, step * batch, v.loss);
  for (const MatchQuality& q : v.quality) {
    row += fmt::format(",{:.4f},{:.3f},{:.2f},{:.4f},{:.3f},{:.3f}", q.median_px,
                       q.outliers_percent, q.confident_percent, q.confident_median_px,
                       q.confident_outliers_percent, q.normalised_median);
  }
  return row;
}

nn::ModelCard card_of(const PretrainVoOptions& options,
                      const PretrainVo& training,
                      const TrainingRequest& request,
                      const std::string& metrics) {
  nn::ModelCard card;
  card.what =
      "matching network of imslam's stereo visual odometry: displacement, uncertainty and "
      "confidence of query points, over time and left to right";
  card.data = fmt::format("{} synthetic triplets of {} x {} px made by this program; textures: {}",
                          training.step_count() * options.batch, options.triplets.scene.width,
                          options.triplets.scene.height, training.data_description());
  card.command = request.command;
  card.seed = fmt::format("{}", options.seed);
  card.metrics = fmt::format("{} validation triplets of other seeds, half of them degraded: {}",
                             options.validation_samples, metrics);
  card.limits =
      "trained on synthetic planar scenes only; flow beyond 80 px from the predicted "
      "displacement and disparities beyond 192 px are not found";
  return card;
}

/// One training with its folder.
class TrainingRun {
 public:
  TrainingRun(const PretrainVoOptions& options, const TrainingRequest& request)
      : options_(options), request_(request), training_(options) {
    const fs::path checkpoint = request.folder / kCheckpoint;
    if (request.resume && fs::exists(checkpoint)) {
      training_.restore(checkpoint);
    } else if (!request.start.empty()) {
      training_.start_from(request.start);
    }
    rows_ = read_log(request.folder / kLog, training_.step_count());
  }

  TrainingOutcome run() {
    outcome_.weights = request_.folder / kWeights;
    while (!training_.done() && !outcome_.stopped) advance();
    training_.save(request_.folder / kCheckpoint);
    outcome_.steps = training_.step_count();
    outcome_.skipped = training_.skipped_steps();
    if (fs::exists(outcome_.weights)) {
      outcome_.best = nn::WeightsFile::read(outcome_.weights).card().metrics;
    }
    return outcome_;
  }

 private:
  void advance() {
    const double loss = training_.step();
    const int step = training_.step_count();
    smooth_loss_ = smooth_loss_ == 0.0 ? loss : 0.95 * smooth_loss_ + 0.05 * loss;
    if (step % options_.validation_every == 0 || training_.done()) validate();
    if (step % options_.checkpoint_every == 0) training_.save(request_.folder / kCheckpoint);
    const std::string note = fmt::format("loss {:.3f}", smooth_loss_);
    outcome_.stopped = request_.keep_going && !request_.keep_going(step, options_.steps, note);
  }

  void validate() {
    const ValidationResult result = training_.validate();
    const int step = training_.step_count();
    if (request_.tell) request_.tell(fmt::format("step {}: {}", step, result.text()));
    rows_.push_back(log_row(step, options_.batch, result));
    write_log(request_.folder / kLog, rows_);
    if (!(result.loss < training_.best_loss)) return;
    training_.best_loss = result.loss;
    training_.write_weights(request_.folder / kWeights,
                            card_of(options_, training_, request_, result.text()));
  }

  const PretrainVoOptions& options_;
  const TrainingRequest& request_;
  PretrainVo training_;
  std::vector<std::string> rows_;
  double smooth_loss_ = 0.0;  // for people only: starts anew after a resume
  TrainingOutcome outcome_;
};

}  // namespace

TrainingOutcome run_pretraining(const PretrainVoOptions& options, const TrainingRequest& request) {
  options.validate();
  prepare_folder(request);
  PretrainVoOptions printed = options;
  Config config;
  config.section("train", printed);
  write_file_atomic(request.folder / "config.yaml", config.to_yaml());
  return TrainingRun(options, request).run();
}

}  // namespace imslam::training

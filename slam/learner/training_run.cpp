#include "slam/learner/training_run.hpp"

#include <fmt/format.h>

#include <chrono>
#include <vector>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"
#include "slam/nn/weights_io.hpp"

namespace imslam::learner {
namespace {

namespace fs = std::filesystem;

const char* const kCheckpoint = "checkpoint.safetensors";
const char* const kLog = "log.csv";

std::string weights_name(const std::string& name) { return name + ".safetensors"; }

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

void write_log(const fs::path& file,
               const std::string& columns,
               const std::vector<std::string>& rows) {
  std::string text =
      "step,samples,loss," + columns + ",gradient_norm,inner_residual,rate,skipped_steps\n";
  for (const std::string& row : rows) text += row + '\n';
  write_file_atomic(file, text);
}

/// One training with its folder.
class TrainingRun {
 public:
  TrainingRun(NetworkTraining& training, const TrainingRequest& request)
      : request_(request), training_(training) {
    const fs::path checkpoint = request.folder / kCheckpoint;
    if (request.resume && fs::exists(checkpoint)) {
      training_.restore(checkpoint);
      rows_ = read_log(request.folder / kLog, training_.step_count());
    } else if (!request.start.empty()) {
      training_.start_from(request.start);
      if (options().guard) look_at_start();
    }
    first_step_ = training_.step_count();
  }

  TrainingOutcome run() {
    outcome_.weights = request_.folder / weights_name(training_.name());
    while (!training_.done() && !outcome_.stopped) advance();
    save();
    outcome_.steps = training_.step_count();
    outcome_.skipped = training_.skipped_steps();
    outcome_.omitted = training_.skipped().text();
    outcome_.early = training_.out_of_patience();
    outcome_.loss_before = training_.start_loss();
    outcome_.loss_after = training_.best_loss();
    if (fs::exists(outcome_.weights)) {
      outcome_.best = nn::WeightsFile::read(outcome_.weights).card().metrics;
    }
    return outcome_;
  }

 private:
  const TrainingOptions& options() const { return training_.common_options(); }

  void advance() {
    const double loss = training_.step();
    const int step = training_.step_count();
    smooth_loss_ = smooth_loss_ == 0.0 ? loss : 0.95 * smooth_loss_ + 0.05 * loss;
    if (step % options().validation_every == 0 || training_.done()) validate();
    if (step % options().checkpoint_every == 0) save();
    outcome_.stopped = request_.keep_going && !request_.keep_going(step, options().steps, note());
  }

  void save() {
    if (request_.writes) training_.save(request_.folder / kCheckpoint);
  }

  /// How it goes, for a progress line that knows rate and time left itself.
  std::string note() const {
    const StepRecord& last = training_.last_step();
    std::string text = fmt::format("loss {:.3f}, gradient {:.2g}, rate {:.1e}", smooth_loss_,
                                   last.gradient_norm, last.rate);
    if (last.residual > 0.0) text += fmt::format(", residual {:.0e}", last.residual);
    if (training_.skipped_steps() > 0)
      text += fmt::format(", {} skipped", training_.skipped_steps());
    return text;
  }

  void validate() {
    const ValidationRecord seen = training_.look();
    note_row(seen);
    if (training_.note_look(seen.loss)) keep_weights(seen);
  }

  void look_at_start() {
    const ValidationRecord seen = training_.look();
    note_row(seen);
    training_.note_start(seen.loss);
    keep_weights(seen);
  }

  void note_row(const ValidationRecord& seen) {
    const int step = training_.step_count();
    if (request_.tell) request_.tell(fmt::format("step {}: {}{}", step, seen.text, pace()));
    const StepRecord& last = training_.last_step();
    rows_.push_back(fmt::format("{},{},{:.6f},{},{:.4g},{:.2g},{:.4g},{}", step,
                                step * options().batch, seen.loss, seen.row, last.gradient_norm,
                                last.residual, last.rate, training_.skipped_steps()));
    if (request_.writes) write_log(request_.folder / kLog, training_.log_columns(), rows_);
  }

  std::string pace() const {
    const int done = training_.step_count() - first_step_;
    if (done <= 0) return "";
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
    const double left_s = elapsed.count() / done * (options().steps - training_.step_count());
    return fmt::format("; {}; {:.2g} steps/s, {:.1f} min left", note(), done / elapsed.count(),
                       left_s / 60.0);
  }

  void keep_weights(const ValidationRecord& seen) {
    if (!request_.writes) return;
    nn::ModelCard card = training_.card();
    card.command = request_.command;
    card.metrics += ": " + seen.text;
    training_.write_weights(request_.folder / weights_name(training_.name()), card);
  }

  const TrainingRequest& request_;
  NetworkTraining& training_;
  std::vector<std::string> rows_;
  int first_step_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double smooth_loss_ = 0.0;  // for people only: starts anew after a resume
  TrainingOutcome outcome_;
};

}  // namespace

void prepare_training_folder(const TrainingRequest& request, const std::string& name) {
  if (!request.writes) return;
  std::error_code error;
  const bool used = fs::exists(request.folder / kCheckpoint) || fs::exists(request.folder / kLog) ||
                    fs::exists(request.folder / weights_name(name));
  if (used && !request.resume && !request.force) {
    throw InputError(request.folder.string() + ": holds a training; --resume goes on with it, " +
                         request.force_flag + " throws it away",
                     ExitCode::kOutput);
  }
  fs::create_directories(request.folder, error);
  if (error) {
    throw InputError(request.folder.string() + ": cannot be made: " + error.message(),
                     ExitCode::kOutput);
  }
  if (request.resume) return;
  for (const std::string& file :
       {std::string(kCheckpoint), weights_name(name), std::string(kLog)}) {
    fs::remove(request.folder / file, error);
  }
}

namespace {

/// Before anything is thrown away: the training can start, and from a file that will still be
/// there.
void check_start(const TrainingRequest& request, const std::string& name) {
  if (request.resume || request.start.empty()) return;
  nn::WeightsFile::read(request.start);
  for (const std::string& file : {weights_name(name), std::string(kCheckpoint)}) {
    std::error_code ignored;
    if (!fs::equivalent(request.start, request.folder / file, ignored)) continue;
    throw InputError(request.start.string() + ": " + request.force_flag +
                         " throws this file away; begin with a copy of it",
                     ExitCode::kUsage);
  }
}

}  // namespace

bool has_checkpoint(const fs::path& folder) { return fs::exists(folder / kCheckpoint); }

TrainingOutcome run_training(NetworkTraining& training,
                             const std::string& config_yaml,
                             const TrainingRequest& request) {
  check_start(request, training.name());
  prepare_training_folder(request, training.name());
  const auto write_config = [&] {
    if (request.writes) write_file_atomic(request.folder / "config.yaml", config_yaml);
  };
  // What is there stays until it is sure that the training goes on with the same options.
  if (!request.resume) write_config();
  TrainingRun run(training, request);
  if (request.resume) write_config();
  return run.run();
}

}  // namespace imslam::learner

#include "app/finetune_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <vector>

#include "app/frame_range.hpp"
#include "app/interrupt.hpp"
#include "app/provenance.hpp"
#include "app/suite_place.hpp"
#include "app/version.hpp"
#include "datasets/open_sequence.hpp"
#include "slam/adaptation/finetune_record.hpp"
#include "slam/adaptation/finetune_tables.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/progress.hpp"
#include "slam/system/run_folder.hpp"
#include "slam/system/run_recorder.hpp"

namespace imslam::app {
namespace fs = std::filesystem;
namespace {

using adaptation::FinetuneRun;

/// The command that makes the result again, for model cards: without what leaves it as it is, so
/// that a fine-tuning that went on after a stop, or in other processes, ends in the same bytes.
std::string essential_command(const std::vector<std::string>& words) {
  const auto is_any = [](const std::string& word, std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), word) != names.end();
  };
  std::string line = "imslam";
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& word = words[i];
    const std::string name = word.substr(0, word.find('='));
    if (is_any(word, {"--resume", "--overwrite", "--quiet", "-q", "--verbose", "-v"})) continue;
    if (is_any(name, {"--threads", "--log-file", "--jobs"})) {
      if (name == word) ++i;
      continue;
    }
    line += " " + word;
  }
  return line;
}

/// The zero-shot run reads these again at the end: they must not be what is written.
void check_networks(const std::string& networks, const fs::path& out) {
  if (networks.empty()) return;
  if (!fs::is_directory(networks)) {
    throw InputError("--networks: expected a folder of weights, got " + networks, ExitCode::kModel);
  }
  if (fs::weakly_canonical(networks) == fs::weakly_canonical(out / "weights")) {
    throw InputError("--networks: these are the results in --out; name another --out",
                     ExitCode::kUsage);
  }
}

/// Neither must any other file of weights that the options name.
void check_weights(const Settings& settings, const fs::path& out) {
  const system::SlamOptions& slam = settings.slam();
  for (const std::string& file :
       {slam.vo.motion_noise, slam.vo.regression.weights, slam.vo.learned.weights,
        slam.imu_network.weights, slam.system.device}) {
    if (file.empty()) continue;
    const fs::path place = fs::weakly_canonical(file);
    if (std::mismatch(out.begin(), out.end(), place.begin(), place.end()).first == out.end()) {
      throw InputError(file + ": lies in --out; name another --out", ExitCode::kUsage);
    }
  }
}

void apply_flags(const FinetuneArguments& arguments, Settings& settings) {
  adaptation::AdaptationOptions& options = settings.adaptation();
  Config& config = settings.config();
  config.set("system.front_end=" + arguments.front_end, "--front-end");
  config.set("system.imu=" + arguments.imu, "--imu");
  if (arguments.epochs) options.epochs = *arguments.epochs;
  if (arguments.force) options.guard = false;
  settings.validate();
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return;
  throw InputError(folder.string() + ": cannot be made: " + error.message(), ExitCode::kOutput);
}

bool is_suite(const std::string& dataset) {
  if (fs::is_directory(dataset)) return false;
  const std::string extension = fs::path(dataset).extension().string();
  return extension == ".yaml" || extension == ".yml" || dataset.rfind("suite_", 0) == 0;
}

/// A sequence to learn from.
struct Source {
  std::string label;  ///< among several; empty: it is the only one
  fs::path folder;
};

/// All sequences of a suite. Throws InputError(kData) if some are not there: to learn from less
/// than was asked for is another fine-tuning.
std::vector<Source> sources_of(const system::Suite& suite, const fs::path& root) {
  std::vector<Source> sources;
  std::string missing;
  for (const system::SuiteSequence& sequence : suite.sequences) {
    const auto found = system::find_sequence(root, sequence);
    if (found) sources.push_back({sequence.name, *found});
    if (!found) missing += (missing.empty() ? "" : ", ") + sequence.name;
  }
  if (missing.empty()) return sources;
  throw InputError(
      fmt::format("{}: these sequences of the suite are not there: {}; take them out "
                  "of a copy of its file, or name another --root",
                  root.string(), missing));
}

/// One call of `imslam finetune`, the same in all its processes.
class FinetuneJob {
 public:
  FinetuneJob(const FinetuneArguments& arguments, const CommonOptions& common)
      : arguments_(arguments), common_(common), options_(settings_.adaptation()) {}

  void print_keys() {
    Config only;
    only.section("finetune", options_);
    std::fputs(only.to_yaml(true).c_str(), stdout);
  }

  /// What can be said before any work.
  void prepare();
  ExitCode run(ProcessGroup& group);

 private:
  void open();
  learner::TrainingRequest request(ProgressBar& bar);
  void record(std::size_t sequence, FinetuneRun which, system::RunOutcome& outcome);
  void tell(const adaptation::FinetuneOutcome& outcome) const;

  const FinetuneArguments& arguments_;
  const CommonOptions& common_;
  Settings settings_;
  adaptation::AdaptationOptions& options_;  ///< those of the settings
  system::SlamOptions slam_;
  std::string name_;  ///< of the sequence or suite
  fs::path folder_;
  std::vector<Source> sources_;
  std::vector<std::unique_ptr<datasets::Sequence>> sequences_;
  std::vector<adaptation::EpochRequest> epochs_;
  int steps_done_ = 0;
};

void FinetuneJob::prepare() {
  if (arguments_.dataset.empty()) {
    throw InputError("finetune: name the folder of a sequence, or a suite", ExitCode::kUsage);
  }
  const bool suite_given = is_suite(arguments_.dataset);
  if (!suite_given && (arguments_.jobs > 1 || !arguments_.root.empty())) {
    throw InputError("--jobs and --root are for suites", ExitCode::kUsage);
  }
  settings_.config().set(std::string("pgo.kernel=") + adaptation::kTeachingKernel, "finetune");
  settings_.config().set(fmt::format("pgo.huber={}", adaptation::kTeachingKernelWidth), "finetune");
  system::Suite suite;
  if (suite_given) suite = system::read_suite(find_config(arguments_.dataset));
  if (!suite.config.empty()) settings_.config().load_file(find_config(suite.config));
  arguments_.layers.apply(settings_);
  apply_flags(arguments_, settings_);
  slam_ = settings_.slam();
  if (!arguments_.networks.empty()) adaptation::use_networks(arguments_.networks, slam_);
  sources_ = {{"", arguments_.dataset}};
  if (suite_given) {
    sources_ = sources_of(suite, choose_root(arguments_.root, arguments_.dataset, suite));
    name_ = system::safe_name(suite.name);
  }
}

/// In every process, after it was forked.
void FinetuneJob::open() {
  for (const Source& source : sources_) {
    sequences_.push_back(datasets::open_sequence(source.folder, arguments_.format));
    adaptation::EpochRequest epoch{*sequences_.back(), slam_, options_, {}, source.label};
    parse_frames(arguments_.frames, epoch.run);
    system::check_request(*sequences_.back(), slam_, epoch.run);
    epochs_.push_back(std::move(epoch));
  }
  if (name_.empty()) name_ = sequences_.front()->name();
  folder_ =
      arguments_.out.empty() ? fs::path("runs") / ("finetune_" + name_) : fs::path(arguments_.out);
}

learner::TrainingRequest FinetuneJob::request(ProgressBar& bar) {
  learner::TrainingRequest request;
  request.folder = folder_;
  request.resume = arguments_.resume;
  request.force = arguments_.overwrite;
  request.force_flag = "--overwrite";
  request.command = essential_command(common_.command_line);
  for (adaptation::EpochRequest& epoch : epochs_) {
    const std::string label = epoch.label.empty() ? "run" : epoch.label;
    epoch.run.keep_going = [this, &bar, label](std::size_t done, std::size_t total) {
      bar.update(done, total, fmt::format("step {}: {}", steps_done_, label));
      return !interrupted();
    };
  }
  request.keep_going = [this, &bar](int done, int steps, const std::string& text) {
    steps_done_ = done;
    bar.update(static_cast<std::size_t>(done), static_cast<std::size_t>(steps), text);
    return !interrupted();
  };
  request.tell = [&bar](const std::string& line) {
    bar.clear();
    log::info("{}", line);
  };
  return request;
}

ExitCode FinetuneJob::run(ProcessGroup& group) {
  open();
  check_networks(arguments_.networks, folder_);
  check_weights(settings_, fs::weakly_canonical(folder_));
  std::unique_ptr<system::FolderLock> lock;
  if (group.rank() == 0) lock = std::make_unique<system::FolderLock>(folder_);
  group.barrier();
  ProgressBar bar("finetune " + name_, group.rank() == 0 && !common_.quiet);
  const auto outcome =
      adaptation::finetune(epochs_, settings_.config().to_yaml(), request(bar), group,
                           [this](std::size_t sequence, FinetuneRun which,
                                  system::RunOutcome& run) { record(sequence, which, run); });
  bar.clear();
  if (group.rank() != 0) return ExitCode::kOk;
  if (outcome.training.stopped) {
    fmt::print("stopped after {} steps; --resume goes on\n", outcome.training.steps);
    return ExitCode::kInterrupted;
  }
  adaptation::record_finetune(folder_, outcome, options_,
                              {name_, adaptation::data_sha256(epochs_), version_text(),
                               essential_command(common_.command_line)});
  tell(outcome);
  return ExitCode::kOk;
}

void FinetuneJob::record(std::size_t sequence, FinetuneRun which, system::RunOutcome& outcome) {
  const bool adapted = which == FinetuneRun::kAdapted;
  fs::path folder = folder_ / (adapted ? "adapted" : "zero_shot");
  if (sources_.size() > 1) folder /= sources_[sequence].label;
  make_folder(folder);
  outcome.summary.networks = adapted ? "adapted to this sequence before the run" : "zero-shot";
  const datasets::Sequence& recording = *sequences_[sequence];
  system::record_run(folder, outcome.result, outcome.summary,
                     provenance_of(settings_, recording, common_), recording.camera(),
                     outcome.evaluation, slam_.system.map_voxel_m);
}

void FinetuneJob::tell(const adaptation::FinetuneOutcome& outcome) const {
  const learner::TrainingOutcome& training = outcome.training;
  const auto print = [](const std::string& text) { std::fputs(text.c_str(), stdout); };
  print(adaptation::comparison_table(outcome.before(), outcome.after()));
  print(adaptation::sequences_table(outcome));
  for (const adaptation::FinetunedSequence& one : outcome.sequences) {
    const auto device = adaptation::device_table(one.device_before, one.device_after);
    if (!device.empty() && outcome.sequences.size() > 1) print(one.name + "\n");
    print(device);
  }
  fmt::print("{}\n", adaptation::guard_text(outcome));
  if (!training.omitted.empty()) {
    log::warn("left out in {} steps: {}", training.steps, training.omitted);
  }
  if (!training.gained()) {
    log::warn("to get the best of the epochs all the same: --force, into another --out");
  }
  for (const fs::path& file : outcome.weights) fmt::print("weights: {}\n", file.string());
  fmt::print("report: {}\n", (folder_ / "report.html").string());
}

}  // namespace

ExitCode finetune(const FinetuneArguments& arguments, const CommonOptions& common) {
  FinetuneJob job(arguments, common);
  if (arguments.list) {
    job.print_keys();
    return ExitCode::kOk;
  }
  job.prepare();
  const HeldInterrupts held;
  ProcessOptions processes;
  processes.jobs = arguments.jobs;
  processes.stopped = [] { return interrupted(); };
  return run_in_processes(processes, [&](ProcessGroup& group) {
    share_processors(common, processes);
    return job.run(group);
  });
}

}  // namespace imslam::app

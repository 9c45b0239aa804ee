#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "app/frame_range.hpp"
#include "app/interrupt.hpp"
#include "app/provenance.hpp"
#include "app/settings.hpp"
#include "app/version.hpp"
#include "datasets/open_sequence.hpp"
#include "slam/adaptation/finetune_record.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/progress.hpp"
#include "slam/system/run_folder.hpp"
#include "slam/system/run_recorder.hpp"

namespace imslam::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  imslam finetune MH_01_easy                        the graph teaches the networks, no "
    "labels\n"
    "  imslam finetune MH_01_easy --epochs 20 --out runs/mh01_tuned\n"
    "  imslam finetune MH_01_easy --out runs/mh01_tuned --resume      go on after a stop\n"
    "  imslam run MH_01_easy --front-end learned --imu learned --networks runs/mh01_tuned/weights\n"
    "  imslam report runs/mh01_tuned                     write its report.html anew\n"
    "`imslam finetune --list` prints every key of the fine-tuning with its default and meaning.";

struct FinetuneArguments {
  std::string dataset;
  std::string format = "auto";
  std::string front_end = "learned";
  std::string imu = "learned";
  std::string out;
  std::string frames;
  std::string networks;
  std::optional<int> epochs;
  bool resume = false;
  bool force = false;
  bool overwrite = false;
  bool list = false;
  ConfigLayers layers;
};

/// The command that makes the result again, for model cards: without what leaves it as it is, so
/// that a fine-tuning that went on after a stop ends in the same bytes.
std::string essential_command(const std::vector<std::string>& words) {
  const auto is_any = [](const std::string& word, std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), word) != names.end();
  };
  std::string line = "imslam";
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& word = words[i];
    const std::string name = word.substr(0, word.find('='));
    if (is_any(word, {"--resume", "--overwrite", "--quiet", "-q", "--verbose", "-v"})) continue;
    if (is_any(name, {"--threads", "--log-file"})) {
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

void apply_flags(const FinetuneArguments& arguments,
                 Settings& settings,
                 adaptation::AdaptationOptions& options) {
  Config& config = settings.config();
  config.set("system.front_end=" + arguments.front_end, "--front-end");
  config.set("system.imu=" + arguments.imu, "--imu");
  if (arguments.epochs) options.epochs = *arguments.epochs;
  if (arguments.force) options.guard = false;
  settings.validate();
  options.validate();
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return;
  throw InputError(folder.string() + ": cannot be made: " + error.message(), ExitCode::kOutput);
}

void record(const fs::path& folder,
            system::RunOutcome outcome,
            const std::string& networks,
            const system::RunProvenance& provenance,
            const StereoCamera& camera,
            double map_voxel_m) {
  make_folder(folder);
  outcome.summary.networks = networks;
  system::record_run(folder, outcome.result, outcome.summary, provenance, camera,
                     outcome.evaluation, map_voxel_m);
}

void tell_result(const adaptation::FinetuneOutcome& outcome, const fs::path& folder) {
  const learner::TrainingOutcome& training = outcome.training;
  std::fputs(adaptation::comparison_table(outcome.before, outcome.after).c_str(), stdout);
  const auto device =
      adaptation::device_table(outcome.zero_shot.result.device, outcome.adapted.result.device);
  std::fputs(device.c_str(), stdout);
  fmt::print("{}\n", adaptation::guard_text(outcome));
  if (!training.omitted.empty()) {
    log::warn("left out in {} steps: {}", training.steps, training.omitted);
  }
  if (!training.gained()) {
    log::warn("to get the best of the epochs all the same: --force, into another --out");
  }
  for (const fs::path& file : outcome.weights) fmt::print("weights: {}\n", file.string());
  fmt::print("report: {}\n", (folder / "report.html").string());
}

ExitCode finetune(const FinetuneArguments& arguments, const CommonOptions& common) {
  Settings settings;
  adaptation::AdaptationOptions options;
  settings.config().section("finetune", options);
  if (arguments.list) {
    Config only;
    only.section("finetune", options);
    std::fputs(only.to_yaml(true).c_str(), stdout);
    return ExitCode::kOk;
  }
  arguments.layers.apply(settings);
  apply_flags(arguments, settings, options);
  if (arguments.dataset.empty()) {
    throw InputError("finetune: name the folder of a sequence", ExitCode::kUsage);
  }
  system::SlamOptions slam = settings.slam();
  if (!arguments.networks.empty()) adaptation::use_networks(arguments.networks, slam);
  const auto sequence = datasets::open_sequence(arguments.dataset, arguments.format);
  adaptation::EpochRequest epoch{*sequence, slam, options, {}};
  parse_frames(arguments.frames, epoch.run);
  system::check_request(*sequence, slam, epoch.run);

  learner::TrainingRequest request;
  request.folder = arguments.out.empty() ? fs::path("runs") / ("finetune_" + sequence->name())
                                         : fs::path(arguments.out);
  request.resume = arguments.resume;
  request.force = arguments.overwrite;
  request.force_flag = "--overwrite";
  request.command = essential_command(common.command_line);
  check_networks(arguments.networks, request.folder);
  make_folder(request.folder);
  const system::FolderLock lock(request.folder);
  const HeldInterrupts held;
  ProgressBar bar("finetune " + sequence->name(), !common.quiet);
  std::string note;
  int steps_done = 0;
  epoch.run.keep_going = [&](std::size_t done, std::size_t total) {
    bar.update(done, total, fmt::format("step {}: run", steps_done));
    return !interrupted();
  };
  request.keep_going = [&](int done, int steps, const std::string& text) {
    steps_done = done;
    bar.update(static_cast<std::size_t>(done), static_cast<std::size_t>(steps), text);
    return !interrupted();
  };
  request.tell = [&](const std::string& line) {
    bar.clear();
    log::info("{}", line);
  };
  const auto outcome = adaptation::finetune(epoch, settings.config().to_yaml(), request);
  bar.clear();
  if (outcome.training.stopped) {
    fmt::print("stopped after {} steps; --resume goes on\n", outcome.training.steps);
    return ExitCode::kInterrupted;
  }
  const auto provenance = provenance_of(settings, *sequence, common);
  record(request.folder / "zero_shot", outcome.zero_shot, "zero-shot", provenance,
         sequence->camera(), slam.system.map_voxel_m);
  record(request.folder / "adapted", outcome.adapted, "adapted to this sequence before the run",
         provenance, sequence->camera(), slam.system.map_voxel_m);
  adaptation::record_finetune(
      request.folder, outcome, options,
      {sequence->name(), adaptation::sequence_sha256(*sequence), version_text(), request.command});
  tell_result(outcome, request.folder);
  return ExitCode::kOk;
}

}  // namespace

void add_finetune_command(CLI::App& app, Action& action, const CommonOptions& common) {
  auto* command =
      app.add_subcommand("finetune", "Let the graph teach the networks on a sequence, no labels");
  command->footer(kExamples);
  auto arguments = std::make_shared<FinetuneArguments>();
  command->add_option("dataset", arguments->dataset, "Folder of the sequence");
  command->add_option("--format", arguments->format, "auto or one of the known formats")
      ->capture_default_str();
  command->add_option("--front-end", arguments->front_end, "klt or learned")->capture_default_str();
  command->add_option("--imu", arguments->imu, "raw, learned or off")->capture_default_str();
  command->add_option("--epochs", arguments->epochs,
                      "Imperative iterations: run, solve the graph, teach (default: 10)");
  command->add_option("--networks", arguments->networks,
                      "Folder of weights to begin with, as finetune writes it");
  command->add_option("--out", arguments->out,
                      "Folder of all results (default: runs/finetune_NAME)");
  command->add_option("--frames", arguments->frames, "Only frames A to B-1")->type_name("A:B");
  auto* resume = command->add_flag(
      "--resume", arguments->resume,
      "Go on with the fine-tuning in --out, however it was stopped: same options, same data");
  command->add_flag(
      "--force", arguments->force,
      "No guard: hand the best epoch back even if it does not gain on what was given");
  command
      ->add_flag("--overwrite", arguments->overwrite,
                 "Throw an earlier fine-tuning in --out away, weights and report included")
      ->excludes(resume);
  command->add_flag("--list", arguments->list, "Print all keys of the fine-tuning and stop");
  arguments->layers.add_options(*command);
  command->callback([&action, arguments, &common] {
    action = [arguments, &common] { return finetune(*arguments, common); };
  });
}

}  // namespace imslam::app

#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "app/settings.hpp"
#include "slam/base/config.hpp"
#include "slam/base/log.hpp"
#include "slam/base/progress.hpp"
#include "slam/learner/training_run.hpp"
#include "slam/system/run_folder.hpp"

namespace imslam::app {

/// What every command that trains a network is told.
struct TrainArguments {
  std::string out;
  std::string start;
  std::vector<std::string> files;
  std::vector<std::string> assignments;
  bool resume = false;
  bool force = false;
  bool list = false;
};

inline std::string joined(const std::vector<std::string>& words) {
  std::string line = "imslam";
  for (std::size_t i = 1; i < words.size(); ++i) line += " " + words[i];
  return line;
}

/// Training: a learner::NetworkTraining made from Options.
template <typename Training, typename Options>
ExitCode train(const std::string& title,
               const TrainArguments& arguments,
               const CommonOptions& common) {
  Options options;
  Config config;
  config.section("train", options);
  config.listed_by(fmt::format("imslam {} --list", title));
  for (const std::string& file : arguments.files) config.load_file(find_config(file));
  for (const std::string& assignment : arguments.assignments)
    config.set("train." + assignment, "--set");
  if (arguments.list) {
    std::fputs(config.to_yaml(true).c_str(), stdout);
    return ExitCode::kOk;
  }
  learner::TrainingRequest request;
  request.folder = arguments.out;
  request.resume = arguments.resume;
  request.force = arguments.force;
  request.start = arguments.start;
  request.command = joined(common.command_line);

  const HeldInterrupts held;
  const system::FolderLock lock(request.folder);  // two calls must not write into one folder
  ProgressBar bar(title, !common.quiet);
  request.keep_going = [&](int done, int steps, const std::string& note) {
    bar.update(static_cast<std::size_t>(done), static_cast<std::size_t>(steps), note);
    return !interrupted();
  };
  request.tell = [&](const std::string& line) {
    bar.clear();
    log::info("{}", line);
  };
  const auto outcome = learner::run_training<Training>(options, request);
  bar.clear();
  if (!outcome.omitted.empty()) {
    log::warn("left out in {} steps: {}", outcome.steps, outcome.omitted);
  }
  if (!outcome.gained()) {
    log::warn(
        "no gain on the given weights (held-out loss {:.6g}): they are the result; to get the "
        "best of the others all the same: --set guard=false",
        *outcome.loss_before);
  }
  if (outcome.early) log::info("ended early: no gain in the last validations (train.patience)");
  fmt::print("{} steps; best: {}\n{}: {}\n", outcome.steps,
             outcome.best.empty() ? "not validated yet" : outcome.best,
             outcome.stopped ? "stopped; --resume goes on" : "weights", outcome.weights.string());
  return outcome.stopped ? ExitCode::kInterrupted : ExitCode::kOk;
}

/// What the struct says; the key names are those of the training's options.
inline void add_training_options(CLI::App& command, TrainArguments& arguments) {
  command.add_option("--out", arguments.out, "Folder of the training")->capture_default_str();
  command.add_option("-c,--config", arguments.files, "YAML file(s), or the name of a shipped one");
  command.add_option("--set", arguments.assignments, "Override one key")->type_name("KEY=VALUE");
  command.add_option("--start", arguments.start, "Weights to begin with")->type_name("FILE");
  command.add_flag("--resume", arguments.resume, "Go on with the training in --out");
  command.add_flag("--force", arguments.force, "Throw an earlier training in --out away");
  command.add_flag("--list", arguments.list, "Print all keys and stop");
}

}  // namespace imslam::app

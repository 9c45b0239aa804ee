#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "app/settings.hpp"
#include "slam/base/config.hpp"
#include "slam/base/log.hpp"
#include "slam/base/progress.hpp"
#include "slam/learner/training_run.hpp"
#include "slam/training/imu_training.hpp"
#include "slam/training/pose_head_training.hpp"
#include "slam/training/pretrain_vo.hpp"

namespace imslam::app {
namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  imslam train vo --config train_vo                 the shipped weights, from nothing\n"
    "  imslam train vo --config train_vo --resume        go on after a stop, bit by bit\n"
    "  imslam train vo --out runs/short --set steps=500 --set batch=8\n"
    "  imslam train imu --config train_imu               the IMU network, on simulated sensors\n"
    "  imslam train imu --set logs=A,B --start FILE      the same on real logs with truth\n"
    "  imslam train pose_head --config train_pose_head   the regression head, from nothing\n"
    "`imslam train vo --list` prints every key with its default and meaning.";

struct TrainArguments {
  std::string out;
  std::string start;
  std::vector<std::string> files;
  std::vector<std::string> assignments;
  bool resume = false;
  bool force = false;
  bool list = false;
};

std::string joined(const std::vector<std::string>& words) {
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

/// One subcommand per network.
template <typename Training, typename Options>
void add_network(CLI::App& parent,
                 const std::string& name,
                 const std::string& description,
                 Action& action,
                 const CommonOptions& common) {
  auto* command = parent.add_subcommand(name, description);
  command->footer(kExamples);
  auto arguments = std::make_shared<TrainArguments>();
  arguments->out = "runs/train_" + name;
  command->add_option("--out", arguments->out, "Folder of the training")->capture_default_str();
  command->add_option("-c,--config", arguments->files,
                      "YAML file(s), or the name of a shipped one");
  command->add_option("--set", arguments->assignments, "Override one key")->type_name("KEY=VALUE");
  command->add_option("--start", arguments->start, "Weights to begin with")->type_name("FILE");
  command->add_flag("--resume", arguments->resume, "Go on with the training in --out");
  command->add_flag("--force", arguments->force, "Throw an earlier training in --out away");
  command->add_flag("--list", arguments->list, "Print all keys and stop");
  command->callback([&action, name, arguments, &common] {
    action = [name, arguments, &common] {
      return train<Training, Options>("train " + name, *arguments, common);
    };
  });
}

}  // namespace

void add_train_command(CLI::App& app, Action& action, const CommonOptions& common) {
  auto* command = app.add_subcommand("train", "Train a network from nothing, without real data");
  command->require_subcommand(1);
  command->footer(kExamples);
  add_network<training::PretrainVo, training::PretrainVoOptions>(
      *command, "vo", "The matching network of the stereo front end", action, common);
  add_network<training::ImuTraining, training::ImuTrainingOptions>(
      *command, "imu", "The network that corrects the IMU", action, common);
  add_network<training::PoseHeadTraining, training::PoseHeadTrainingOptions>(
      *command, "pose_head", "The pose head of vo.head: regression", action, common);
}

}  // namespace imslam::app

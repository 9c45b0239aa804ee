#include <memory>
#include <string>

#include "app/command.hpp"
#include "app/training_command.hpp"
#include "slam/training/imu_training.hpp"
#include "slam/training/pose_head_training.hpp"
#include "slam/training/pretrain_vo.hpp"

namespace imslam::app {
namespace {

constexpr const char* kTrainExamples =
    "Examples:\n"
    "  imslam train vo --config train_vo                 the shipped weights, from nothing\n"
    "  imslam train vo --config train_vo --resume        go on after a stop, bit by bit\n"
    "  imslam train vo --out runs/short --set steps=500 --set batch=8\n"
    "  imslam train imu --config train_imu               the IMU network, on simulated sensors\n"
    "  imslam train imu --set logs=A,B --start FILE      the same on real logs with truth\n"
    "  imslam train pose_head --config train_pose_head   the regression head, from nothing\n"
    "`imslam train vo --list` prints every key with its default and meaning.";

/// One subcommand per network.
template <typename Training, typename Options>
void add_network(CLI::App& parent,
                 const std::string& name,
                 const std::string& description,
                 Action& action,
                 const CommonOptions& common) {
  auto* command = parent.add_subcommand(name, description);
  command->footer(kTrainExamples);
  auto arguments = std::make_shared<TrainArguments>();
  arguments->out = "runs/train_" + name;
  add_training_options(*command, *arguments);
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
  command->footer(kTrainExamples);
  add_network<training::PretrainVo, training::PretrainVoOptions>(
      *command, "vo", "The matching network of the stereo front end", action, common);
  add_network<training::ImuTraining, training::ImuTrainingOptions>(
      *command, "imu", "The network that corrects the IMU", action, common);
  add_network<training::PoseHeadTraining, training::PoseHeadTrainingOptions>(
      *command, "pose_head", "The pose head of vo.head: regression", action, common);
}

}  // namespace imslam::app

#include <memory>

#include "app/command.hpp"
#include "app/finetune_job.hpp"

namespace imslam::app {
namespace {

constexpr const char* kFinetuneExamples =
    "Examples:\n"
    "  imslam finetune MH_01_easy                        the graph teaches the networks, no "
    "labels\n"
    "  imslam finetune MH_01_easy --epochs 20 --out runs/mh01_tuned\n"
    "  imslam finetune MH_01_easy --out runs/mh01_tuned --resume      go on after a stop\n"
    "  imslam finetune suite_euroc --root /data/euroc --jobs 4        on all its sequences at "
    "once\n"
    "  mpirun -n 8 imslam finetune my_suite.yaml                      on several machines\n"
    "  imslam run MH_01_easy --front-end learned --imu learned --networks runs/mh01_tuned/weights\n"
    "  imslam report runs/mh01_tuned                     write its report.html anew\n"
    "`imslam finetune --list` prints every key of the fine-tuning with its default and meaning.";

}  // namespace

void add_finetune_command(CLI::App& app, Action& action, const CommonOptions& common) {
  auto* command = app.add_subcommand(
      "finetune", "Let the graph teach the networks on a sequence or a suite, no labels");
  command->footer(kFinetuneExamples);
  auto arguments = std::make_shared<FinetuneArguments>();
  command->add_option("dataset", arguments->dataset,
                      "Folder of the sequence; or a suite: a file, or suite_kitti, suite_euroc");
  command->add_option("--root", arguments->root, "Folder that holds the sequences of the suite");
  command->add_option("--jobs", arguments->jobs, "Processes on this machine, for a suite")
      ->capture_default_str();
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

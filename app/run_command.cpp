#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "app/default_sequence.hpp"
#include "app/frame_range.hpp"
#include "app/interrupt.hpp"
#include "app/provenance.hpp"
#include "app/settings.hpp"
#include "datasets/check.hpp"
#include "datasets/open_sequence.hpp"
#include "slam/adaptation/learned_networks.hpp"
#include "slam/adaptation/online_adapter.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/progress.hpp"
#include "slam/system/run_folder.hpp"
#include "slam/system/run_recorder.hpp"
#include "slam/system/run_sequence.hpp"

namespace imslam::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRunExamples =
    "Examples:\n"
    "  imslam run                                    the built-in simulated sequence\n"
    "  imslam run MH_01_easy --out runs/mh01         a EuRoC folder\n"
    "  imslam run sequences/00 --frames 0:500        part of a KITTI sequence\n"
    "  imslam run MH_01_easy --imu off               vision only\n"
    "  imslam run MH_01_easy --front-end learned     matching by the trained network\n"
    "  imslam run MH_01_easy --front-end learned --imu learned --networks tuned/weights\n"
    "  imslam run MH_01_easy --front-end learned --imu learned --adapt    learn on the way\n"
    "  imslam run MH_01_easy --config paper_euroc    the published method's graph\n"
    "  imslam run MH_01_easy --set pgo.huber=3 --json";

struct RunArguments {
  std::string dataset;
  std::string format = "auto";
  std::string front_end;
  std::string imu;
  std::string out;
  std::string runs = "runs";
  std::string frames;
  std::string networks;
  int seed = -1;
  bool json = false;
  bool force = false;
  bool adapt = false;
  ConfigLayers layers;
};

void apply_flags(const RunArguments& arguments, Settings& settings) {
  Config& config = settings.config();
  if (!arguments.front_end.empty()) {
    config.set("system.front_end=" + arguments.front_end, "--front-end");
  }
  if (!arguments.imu.empty()) config.set("system.imu=" + arguments.imu, "--imu");
  if (!arguments.networks.empty()) {
    for (const std::string& assignment : adaptation::network_assignments(arguments.networks)) {
      config.set(assignment, "--networks");
    }
  }
  if (arguments.seed >= 0) config.set(fmt::format("system.seed={}", arguments.seed), "--seed");
  settings.validate();
}

/// Exchanged images give a mirrored world: better no result than that one.
void expect_stereo_order(datasets::Sequence& sequence) {
  const auto finding = datasets::check_stereo_order(sequence);
  if (finding) throw InputError(finding->what + "; " + finding->remedy, ExitCode::kCalibration);
}

ExitCode exit_code_of(const system::RunOutcome& outcome) {
  if (outcome.stopped || interrupted()) return ExitCode::kInterrupted;
  return outcome.result.tracking_lost ? ExitCode::kTrackingLost : ExitCode::kOk;
}

ExitCode run(const RunArguments& arguments, const CommonOptions& common) {
  Settings settings;
  arguments.layers.apply(settings);
  apply_flags(arguments, settings);
  system::RunRequest request;
  parse_frames(arguments.frames, request);

  const fs::path dataset = arguments.dataset.empty()
                               ? make_default_sequence(arguments.runs, common.quiet)
                               : fs::path(arguments.dataset);
  const auto sequence = datasets::open_sequence(dataset, arguments.format);
  system::check_request(*sequence, settings.slam(), request);
  expect_stereo_order(*sequence);
  const HeldInterrupts held;  // from here on there is something to save
  system::RunFolder folder =
      system::make_run_folder(arguments.runs, sequence->name(), arguments.out, arguments.force);

  std::unique_ptr<adaptation::OnlineAdapter> adapter;
  if (arguments.adapt) {
    adapter = std::make_unique<adaptation::OnlineAdapter>(settings.slam(), settings.adaptation(),
                                                          *sequence);
    adapter->attach(request);
  }
  ProgressBar bar(sequence->name(), !common.quiet);
  request.keep_going = [&](std::size_t done, std::size_t total) {
    bar.update(done, total);
    return !interrupted();
  };
  auto outcome = system::run_sequence(*sequence, settings.slam(), request);
  bar.clear();
  if (adapter) outcome.summary.networks = adapter->summary();
  system::record_run(folder.path(), outcome.result, outcome.summary,
                     provenance_of(settings, *sequence, common), sequence->camera(),
                     outcome.evaluation, settings.slam().system.map_voxel_m);
  folder.publish();
  if (arguments.out.empty()) system::update_latest_link(folder.path());

  const std::string metrics = read_file(folder.path() / "metrics.json");
  const auto parsed = nlohmann::json::parse(metrics);
  for (const auto& warning : parsed.at("warnings")) log::warn("{}", warning.get<std::string>());
  if (arguments.json) {
    std::fputs(metrics.c_str(), stdout);
  } else {
    std::fputs(system::metrics_table(parsed).c_str(), stdout);
    std::printf("report: %s\n", (folder.path() / "report.html").c_str());
  }
  return exit_code_of(outcome);
}

}  // namespace

void add_run_command(CLI::App& app, Action& action, const CommonOptions& common) {
  auto* command = app.add_subcommand("run", "Estimate the trajectory of a sequence and report");
  command->footer(kRunExamples);
  auto arguments = std::make_shared<RunArguments>();
  command->add_option("dataset", arguments->dataset,
                      "Folder of the sequence; none: the built-in simulated one");
  command->add_option("--format", arguments->format, "auto or one of the known formats")
      ->capture_default_str();
  command->add_option("--front-end", arguments->front_end, "klt or learned");
  command->add_option("--imu", arguments->imu, "raw, learned or off");
  command->add_option("--out", arguments->out, "Run folder (default: runs/<time>_<dataset>)");
  command->add_option("--runs", arguments->runs, "Where run folders go")->capture_default_str();
  command->add_option("--frames", arguments->frames, "Only frames A to B-1")->type_name("A:B");
  command->add_option("--networks", arguments->networks,
                      "Folder of weights that `imslam finetune` wrote");
  command->add_option("--seed", arguments->seed, "Seed of all randomness, 0 or more")
      ->check(CLI::Range(0, std::numeric_limits<int>::max()));
  command->add_flag("--adapt", arguments->adapt,
                    "Let the networks learn from the past while the run goes on");
  command->add_flag("--json", arguments->json, "Print metrics.json instead of the table");
  command->add_flag("--force", arguments->force, "Replace an earlier run in --out");
  arguments->layers.add_options(*command);
  command->callback([&action, arguments, &common] {
    action = [arguments, &common] { return run(*arguments, common); };
  });
}

}  // namespace imslam::app

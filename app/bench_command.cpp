#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "app/bench_rows.hpp"
#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "app/suite_place.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/process_group.hpp"
#include "slam/system/run_folder.hpp"
#include "slam/system/suite_bench.hpp"

namespace imslam::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kBenchExamples =
    "Examples:\n"
    "  imslam bench suite_euroc --root /data/euroc             the published table and our rows\n"
    "  imslam bench suite_kitti --root /data/kitti --jobs 4    four processes\n"
    "  mpirun -n 8 imslam bench suite_kitti --root /data/kitti on several machines\n"
    "  imslam bench my_suite.yaml --variants vo,vision,graph --front-end learned\n"
    "Rows (--variants): vo = odometry alone, IMU off; vision = graph without IMU; graph = graph "
    "with IMU;\nonline_vo, online = networks that learn on the way; adapted_vo, adapted = networks "
    "that "
    "learned on the\nsequence before the run (learned front end and IMU; odometry and graph of "
    "that run).\n"
    "A second call uses the runs that are there, if they are of the same program, options and "
    "data.\n"
    "Without --root the environment's IMSLAM_SUITE_ROOT counts, then the file's root.";

/// What is published, and which sequences are there.
ExitCode list(const BenchArguments& arguments, const system::Suite& suite) {
  std::fputs(system::as_text(system::make_suite_table(suite, {})).c_str(), stdout);
  const fs::path root = given_root(arguments.root, suite);
  for (const system::SuiteSequence& sequence : suite.sequences) {
    const auto found = root.empty() ? std::nullopt : system::find_sequence(root, sequence);
    std::printf("%s: %s\n", sequence.name.c_str(), found ? found->c_str() : "not there");
  }
  return ExitCode::kOk;
}

ExitCode bench(const BenchArguments& arguments, const CommonOptions& common) {
  const system::Suite suite = system::read_suite(find_config(arguments.suite));
  if (arguments.list) return list(arguments, suite);
  const fs::path root = choose_root(arguments.root, arguments.suite, suite);
  const fs::path out = arguments.out.empty()
                           ? fs::path("runs") / ("bench_" + system::safe_name(suite.name))
                           : fs::path(arguments.out);
  make_methods(arguments, common, suite, out, false);  // wrong options are told before any work
  const HeldInterrupts held;
  ProcessOptions processes;
  processes.jobs = arguments.jobs;
  processes.stopped = [] { return interrupted(); };
  return run_in_processes(processes, [&](ProcessGroup& group) {
    std::unique_ptr<system::FolderLock> lock;  // two calls must not write into one folder
    if (group.rank() == 0) lock = std::make_unique<system::FolderLock>(out);
    group.barrier();
    share_processors(common, processes);
    const bool show_progress = group.size() == 1 && !common.quiet;
    const auto rows = system::run_suite(
        suite, root, make_methods(arguments, common, suite, out, show_progress), group);
    if (group.rank() != 0) return ExitCode::kOk;
    const system::SuiteTable table = system::make_suite_table(suite, rows);
    const std::string text = system::as_text(table);
    write_file_atomic(out / "table.txt", text);
    write_file_atomic(out / "table.csv", system::as_csv(table));
    write_file_atomic(out / "table.tex", system::as_latex(table));
    std::fputs(text.c_str(), stdout);
    log::info("table.txt, table.csv, table.tex and all runs are in {}", out.string());
    return interrupted() ? ExitCode::kInterrupted : system::exit_code_of(rows);
  });
}

}  // namespace

void add_bench_command(CLI::App& app, Action& action, const CommonOptions& common) {
  auto* command =
      app.add_subcommand("bench", "Run a suite of sequences; the published table and ours");
  command->footer(kBenchExamples);
  auto arguments = std::make_shared<BenchArguments>();
  command->add_option("suite", arguments->suite, "Suite file, or suite_kitti, suite_euroc")
      ->required();
  command->add_option("--root", arguments->root, "Folder that holds the sequences");
  command->add_option("--out", arguments->out, "Runs and tables (default: runs/bench_<name>)");
  command
      ->add_option("--variants", arguments->variants,
                   "Rows: vo, vision, graph, online_vo, online, adapted_vo, adapted")
      ->capture_default_str();
  command
      ->add_option("--weights-vo", arguments->weights_vo,
                   "Weights of the matching network; implies --front-end learned")
      ->check(CLI::ExistingFile);
  command->add_option("--front-end", arguments->front_end, "klt or learned");
  command->add_option("--jobs", arguments->jobs, "Processes on this machine")
      ->capture_default_str();
  command->add_flag("--force", arguments->force, "Run again what is there already");
  command->add_flag("--list", arguments->list,
                    "Only print what is published and which sequences are there");
  arguments->layers.add_options(*command);
  command->callback([&action, arguments, &common] {
    action = [arguments, &common] { return bench(*arguments, common); };
  });
}

}  // namespace imslam::app

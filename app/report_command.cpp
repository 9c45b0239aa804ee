#include <cstdio>
#include <filesystem>
#include <string>

#include "app/command.hpp"
#include "slam/base/error.hpp"
#include "slam/report/report.hpp"

namespace imslam::app {
namespace {

/// Nobody's folder gets a report by mistake; a damaged run, which lacks files, does.
void expect_run(const std::filesystem::path& folder) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) return;  // said by what reads it
  for (const char* name : {"metrics.json", "manifest.json", "trajectory.tum", "log.csv"}) {
    if (std::filesystem::exists(folder / name, ignored)) return;
  }
  throw InputError(folder.string() +
                   ": no run folder (no metrics.json, manifest.json or trajectory.tum); give one "
                   "that `imslam run` or `imslam finetune` wrote");
}

}  // namespace

void add_report_command(CLI::App& app, Action& action) {
  auto* report = app.add_subcommand("report", "Write report.html of a run folder anew");
  report->footer("Example:\n  imslam report runs/latest");
  auto folder = std::make_shared<std::string>("runs/latest");
  report->add_option("run", *folder, "Run folder")->capture_default_str();
  report->callback([&action, folder] {
    action = [folder] {
      expect_run(*folder);
      report::write_report(*folder);
      std::printf("%s\n", (std::filesystem::path(*folder) / "report.html").c_str());
      return ExitCode::kOk;
    };
  });
}

}  // namespace imslam::app

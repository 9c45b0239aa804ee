#include <cstdio>
#include <filesystem>
#include <string>

#include "app/command.hpp"
#include "slam/report/report.hpp"

namespace imslam::app {

void add_report_command(CLI::App& app, Action& action) {
  auto* report = app.add_subcommand("report", "Write report.html of a run folder anew");
  report->footer("Example:\n  imslam report runs/latest");
  auto folder = std::make_shared<std::string>("runs/latest");
  report->add_option("run", *folder, "Run folder")->capture_default_str();
  report->callback([&action, folder] {
    action = [folder] {
      report::write_report(*folder);
      std::printf("%s\n", (std::filesystem::path(*folder) / "report.html").c_str());
      return ExitCode::kOk;
    };
  });
}

}  // namespace imslam::app

#include <fmt/color.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "datasets/check.hpp"

namespace imslam::app {
namespace {

using datasets::Finding;
using datasets::Severity;

constexpr const char* kCheckExamples =
    "Examples:\n"
    "  imslam check MH_01_easy\n"
    "  imslam check my_recording --all-images --json\n"
    "Exit codes: 0 nothing wrong (warnings allowed), 3 errors in data, 4 errors in calibration,\n"
    "  10 with --strict: warnings only";

struct CheckArguments {
  std::string folder;
  datasets::CheckOptions options;
  bool json = false;
  bool strict = false;
};

const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::kError:
      return "error";
    case Severity::kWarning:
      return "warning";
    case Severity::kInfo:
      break;
  }
  return "info";
}

std::string place_of(const Finding& finding) {
  return finding.line > 0 ? fmt::format("{}:{}", finding.file, finding.line) : finding.file;
}

void print_text(const std::vector<Finding>& findings) {
  const bool colour = isatty(STDOUT_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr;
  for (const Finding& finding : findings) {
    auto style = fmt::text_style();
    if (colour && finding.severity == Severity::kError) style = fg(fmt::terminal_color::red);
    if (colour && finding.severity == Severity::kWarning) style = fg(fmt::terminal_color::yellow);
    fmt::print("{} {}{}{}\n", fmt::format(style, "{:<8}", name_of(finding.severity)),
               place_of(finding), finding.file.empty() ? "" : ": ", finding.what);
    if (!finding.remedy.empty()) fmt::print("         -> {}\n", finding.remedy);
  }
}

void print_json(const std::vector<Finding>& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"severity", name_of(finding.severity)},
                    {"file", finding.file},
                    {"line", finding.line},
                    {"what", finding.what},
                    {"remedy", finding.remedy}});
  }
  // Paths may hold bytes that are not UTF-8; JSON may not.
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
  fmt::print("{}\n", nlohmann::json{{"findings", list}}.dump(2, ' ', false, kReplace));
}

ExitCode exit_code_of(const std::vector<Finding>& findings, bool strict) {
  const auto has = [&](auto&& test) { return std::any_of(findings.begin(), findings.end(), test); };
  const auto is_error = [](const Finding& f) { return f.severity == Severity::kError; };
  if (has([&](const Finding& f) { return is_error(f) && f.code == ExitCode::kCalibration; })) {
    return ExitCode::kCalibration;
  }
  if (has(is_error)) return ExitCode::kData;
  const bool warned = has([](const Finding& f) { return f.severity == Severity::kWarning; });
  return strict && warned ? ExitCode::kWarnings : ExitCode::kOk;
}

ExitCode check(const CheckArguments& arguments) {
  arguments.options.validate();
  const auto findings = datasets::check_sequence(arguments.folder, arguments.options);
  if (arguments.json) {
    print_json(findings);
  } else {
    print_text(findings);
  }
  return exit_code_of(findings, arguments.strict);
}

}  // namespace

void add_check_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("check", "List everything that is wrong with a recording");
  command->footer(kCheckExamples);
  auto arguments = std::make_shared<CheckArguments>();
  command->add_option("folder", arguments->folder, "Folder of the sequence")->required();
  command->add_option("--format", arguments->options.format, "auto or one of the known formats")
      ->capture_default_str();
  command->add_flag("--all-images", arguments->options.all_images, "Decode every image");
  command
      ->add_option("--vision-frames", arguments->options.vision_frames,
                   "Frames for the checks of geometry and clocks, 0: none")
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print the findings as JSON");
  command->add_flag("--strict", arguments->strict, "Exit code 10 if there are warnings");
  command->callback([&action, arguments] { action = [arguments] { return check(*arguments); }; });
}

}  // namespace imslam::app

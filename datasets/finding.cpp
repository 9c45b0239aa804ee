#include "datasets/finding.hpp"

#include <optional>

#include "slam/base/text.hpp"

namespace imslam::datasets {
namespace {

/// Takes ":12" off the end of `text`, if it is there.
std::optional<std::size_t> take_number(std::string& text) {
  const auto colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  const auto number = parse_int64(std::string_view(text).substr(colon + 1));
  if (!number || *number < 0) return std::nullopt;
  text.resize(colon);
  return static_cast<std::size_t>(*number);
}

}  // namespace

std::string to_text(const Finding& finding) {
  std::string text = finding.severity == Severity::kError     ? "error: "
                     : finding.severity == Severity::kWarning ? "warning: "
                                                              : "info: ";
  if (!finding.file.empty()) text += finding.file;
  if (finding.line > 0) text += ":" + std::to_string(finding.line);
  if (!finding.file.empty()) text += ": ";
  text += finding.what;
  if (!finding.remedy.empty()) text += "; " + finding.remedy;
  return text;
}

void Findings::info(const std::string& what, const std::string& file) {
  all_.push_back({Severity::kInfo, file, 0, what, "", ExitCode::kOk});
}

void Findings::warn(const std::string& what,
                    const std::string& remedy,
                    const std::string& file,
                    std::size_t line) {
  all_.push_back(
      {Severity::kWarning, file.empty() ? file_ : file, line, what, remedy, ExitCode::kOk});
}

void Findings::fail(ExitCode code,
                    const std::string& what,
                    const std::string& remedy,
                    const std::string& file,
                    std::size_t line) {
  all_.push_back({Severity::kError, file.empty() ? file_ : file, line, what, remedy, code});
}

void Findings::fail(const InputError& error) {
  std::string text = error.what();
  std::string file;
  std::size_t line = 0;
  if (const auto end = text.find(": "); end != std::string::npos) {
    file = text.substr(0, end);
    text.erase(0, end + 2);
    const auto last = take_number(file);
    const auto before = last ? take_number(file) : std::nullopt;  // line and column
    line = before.value_or(last.value_or(0));
  }
  std::string remedy;
  if (const auto semicolon = text.rfind("; "); semicolon != std::string::npos) {
    remedy = text.substr(semicolon + 2);
    text.resize(semicolon);
  }
  fail(error.code(), text, remedy, file, line);
}

}  // namespace imslam::datasets

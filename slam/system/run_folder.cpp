#include "slam/system/run_folder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cctype>
#include <ctime>
#include <system_error>

#include "slam/base/error.hpp"

namespace imslam::system {
namespace fs = std::filesystem;
namespace {

constexpr int kMostRunsPerSecond = 1000;

void create(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw InputError(fmt::format("{}: cannot be created ({}); choose another place with --out",
                                 folder.string(), error.message()),
                     ExitCode::kOutput);
  }
}

fs::path take_given(const fs::path& out, bool force) {
  const bool occupied = fs::exists(out) && (!fs::is_directory(out) || !fs::is_empty(out));
  const bool earlier_run = fs::exists(out / "manifest.json");
  if (occupied && !(force && earlier_run)) {
    throw InputError(fmt::format("{}: exists and is not empty; name another --out{}", out.string(),
                                 earlier_run ? " or add --force to replace that run" : ""),
                     ExitCode::kOutput);
  }
  create(out);
  return out;
}

}  // namespace

std::string safe_name(const std::string& name) {
  std::string safe;
  for (const char c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.';
    safe += plain ? c : '_';
  }
  return safe.empty() ? "sequence" : safe;
}

fs::path make_run_folder(const fs::path& runs_root,
                         const std::string& dataset,
                         const fs::path& out,
                         bool force) {
  if (!out.empty()) return take_given(out, force);
  const std::time_t now = std::time(nullptr);
  const std::string base =
      fmt::format("{:%Y-%m-%d_%H-%M-%S}_{}", fmt::localtime(now), safe_name(dataset));
  create(runs_root);
  for (int number = 1; number < kMostRunsPerSecond; ++number) {
    const fs::path folder = runs_root / (number == 1 ? base : fmt::format("{}_{}", base, number));
    std::error_code error;
    // create_directory says false if another process was faster: take the next number.
    if (fs::create_directory(folder, error)) return folder;
    if (error) break;
  }
  throw InputError(fmt::format("{}: no run folder can be created there", runs_root.string()),
                   ExitCode::kOutput);
}

void update_latest_link(const fs::path& folder) {
  const fs::path absolute = fs::absolute(folder).lexically_normal();
  const fs::path link = absolute.parent_path() / "latest";
  const fs::path fresh =
      absolute.parent_path() / fmt::format(".latest.{}", absolute.filename().string());
  std::error_code ignored;
  if (fs::exists(link) && !fs::is_symlink(link)) return;
  fs::create_directory_symlink(absolute.filename(), fresh, ignored);
  if (!ignored) fs::rename(fresh, link, ignored);
}

}  // namespace imslam::system

#include "slam/system/run_folder.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
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

/// The descriptor that holds the lock, released when the process ends however it ends; -1 where
/// the file system knows no locks.
int lock_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0 || ::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  const bool taken = errno == EWOULDBLOCK;
  ::close(descriptor);
  if (!taken) return -1;
  throw InputError(
      fmt::format("{}: another run is writing there; name another --out", folder.string()),
      ExitCode::kOutput);
}

/// Hidden beside `final_place`, on the same file system.
fs::path staging_beside(const fs::path& final_place) {
  const std::string name = final_place.filename().string();
  return final_place.parent_path() / fmt::format(".{}.{}.new", name, ::getpid()) / name;
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

FolderLock::FolderLock(const fs::path& folder) {
  create(folder);
  descriptor_ = lock_folder(folder);
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

RunFolder::RunFolder(RunFolder&& other) noexcept
    : path_(std::move(other.path_)),
      replaced_(std::exchange(other.replaced_, {})),
      lock_(std::exchange(other.lock_, -1)) {}

RunFolder::~RunFolder() {
  std::error_code ignored;
  if (!replaced_.empty()) fs::remove_all(path_.parent_path(), ignored);
  if (lock_ >= 0) ::close(lock_);
}

void RunFolder::publish() {
  if (replaced_.empty()) return;
  const fs::path final_place = std::exchange(replaced_, {});
  const fs::path earlier = path_.parent_path() / "earlier";
  std::error_code error;
  fs::rename(final_place, earlier, error);
  if (!error) fs::rename(path_, final_place, error);
  if (error) {
    std::error_code ignored;
    fs::rename(earlier, final_place, ignored);
    throw InputError(fmt::format("{}: cannot be replaced ({}); the run is in {}",
                                 final_place.string(), error.message(), path_.string()),
                     ExitCode::kOutput);
  }
  fs::remove_all(path_.parent_path(), error);
  path_ = final_place;
}

RunFolder RunFolder::take(const fs::path& out, bool force) {
  std::error_code ignored;  // creating it says what is wrong with the name
  if (!fs::exists(out, ignored)) create(out);
  if (!fs::is_directory(out, ignored)) {
    throw InputError(fmt::format("{}: is no folder; name another --out", out.string()),
                     ExitCode::kOutput);
  }
  RunFolder taken(out, lock_folder(out));
  if (fs::is_empty(out)) return taken;
  const bool earlier_run = fs::exists(out / "manifest.json");
  if (!force || !earlier_run) {
    const char* advice = earlier_run ? " or add --force to replace that run"
                         : force     ? "; --force replaces earlier runs only, and this is none"
                                     : "";
    throw InputError(
        fmt::format("{}: exists and is not empty; name another --out{}", out.string(), advice),
        ExitCode::kOutput);
  }
  const fs::path final_place = fs::canonical(out);
  taken.path_ = staging_beside(final_place);
  create(taken.path_);
  taken.replaced_ = final_place;
  return taken;
}

RunFolder make_run_folder(const fs::path& runs_root,
                          const std::string& dataset,
                          const fs::path& out,
                          bool force) {
  if (!out.empty()) return RunFolder::take(out, force);
  const std::time_t now = std::time(nullptr);
  const std::string base =
      fmt::format("{:%Y-%m-%d_%H-%M-%S}_{}", fmt::localtime(now), safe_name(dataset));
  create(runs_root);
  for (int number = 1; number < kMostRunsPerSecond; ++number) {
    const fs::path folder = runs_root / (number == 1 ? base : fmt::format("{}_{}", base, number));
    std::error_code error;
    // create_directory says false if another process was faster: take the next number.
    if (fs::create_directory(folder, error)) return RunFolder(folder, lock_folder(folder));
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

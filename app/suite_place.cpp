#include "app/suite_place.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"

namespace imslam::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRootVariable = "IMSLAM_SUITE_ROOT";

}  // namespace

fs::path given_root(const std::string& root, const system::Suite& suite) {
  if (!root.empty()) return root;
  const char* variable = std::getenv(kRootVariable);
  return variable != nullptr && *variable != '\0' ? fs::path(variable) : suite.root;
}

fs::path choose_root(const std::string& root,
                     const std::string& suite_name,
                     const system::Suite& suite) {
  const fs::path place = given_root(root, suite);
  if (place.empty()) {
    throw InputError(
        fmt::format("{}: where are the sequences? give --root or {}", suite_name, kRootVariable),
        ExitCode::kUsage);
  }
  if (!fs::is_directory(place)) {
    throw InputError(
        fmt::format("{}: no such folder; give the one that holds the sequences with "
                    "--root or {}",
                    place.string(), kRootVariable));
  }
  return place;
}

void share_processors(const CommonOptions& common, const ProcessOptions& processes) {
  if (common.threads > 0) return;
  const auto all = static_cast<int>(std::thread::hardware_concurrency());
  set_thread_count(std::max(1, all / processes_on_this_machine(processes)));
}

}  // namespace imslam::app

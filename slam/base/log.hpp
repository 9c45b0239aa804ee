#pragma once

#include <spdlog/spdlog.h>

#include <filesystem>
#include <string>

namespace imslam::log {

using spdlog::debug;
using spdlog::error;
using spdlog::info;
using spdlog::warn;

enum class Level { kQuiet, kNormal, kVerbose };

/// Messages go to stderr (data goes to stdout), warnings and errors marked.
void start(Level level);

/// Also writes every message, debug ones included, to `file` until the process ends.
void add_file(const std::filesystem::path& file);

}  // namespace imslam::log

#include "slam/base/log.hpp"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>

#include <memory>

#include "slam/base/error.hpp"

namespace imslam::log {
namespace {

spdlog::level::level_enum console_level(Level level) {
  switch (level) {
    case Level::kQuiet:
      return spdlog::level::err;
    case Level::kVerbose:
      return spdlog::level::debug;
    case Level::kNormal:
      break;
  }
  return spdlog::level::info;
}

}  // namespace

void start(Level level) {
  const auto console = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  console->set_level(console_level(level));
  console->set_pattern("%^%l:%$ %v");
  const auto logger = std::make_shared<spdlog::logger>("imslam", console);
  logger->set_level(spdlog::level::debug);
  spdlog::set_default_logger(logger);
}

void add_file(const std::filesystem::path& file) {
  std::shared_ptr<spdlog::sinks::basic_file_sink_mt> sink;
  try {
    sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(file.string(), true);
  } catch (const spdlog::spdlog_ex& error) {
    throw InputError(
        fmt::format("{}: no messages can be written there ({})", file.string(), error.what()),
        ExitCode::kOutput);
  }
  sink->set_level(spdlog::level::debug);
  sink->set_pattern("%H:%M:%S.%e %l: %v");
  spdlog::default_logger()->sinks().push_back(sink);
}

}  // namespace imslam::log

#include "app/settings.hpp"

#include <filesystem>

#include "slam/base/error.hpp"

namespace imslam::app {

std::filesystem::path find_config(const std::string& name) {
  std::error_code ignored;
  if (std::filesystem::exists(name, ignored)) return name;
  const std::filesystem::path shipped(IMSLAM_CONFIG_FOLDER);
  for (const auto& candidate : {shipped / name, shipped / (name + ".yaml")}) {
    if (std::filesystem::exists(candidate, ignored)) return candidate;
  }
  throw InputError(name + ": no such config file; shipped ones are in " + shipped.string(),
                   ExitCode::kUsage);
}

Settings::Settings() {
  slam_.describe(config_);
  config_.section("finetune", adaptation_);
}

void Settings::validate() const {
  slam_.validate();
  adaptation_.validate();
}

void ConfigLayers::add_options(CLI::App& command) {
  command.add_option("-c,--config", files_, "YAML file(s), or the name of a shipped one")
      ->type_name("FILE");
  command.add_option("--set", assignments_, "Override one key, e.g. --set pgo.huber=1.0")
      ->type_name("KEY=VALUE");
}

void ConfigLayers::apply(Settings& settings) const {
  Config& config = settings.config();
  for (const std::string& file : files_) config.load_file(find_config(file));
  config.load_environment();
  for (const std::string& assignment : assignments_) config.set(assignment, "--set");
  settings.validate();
}

}  // namespace imslam::app

#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "slam/adaptation/adaptation_options.hpp"
#include "slam/base/config.hpp"
#include "slam/system/slam_options.hpp"

namespace imslam::app {

/// All option structs of `imslam run` and `imslam finetune`, bound to one config. Not copyable: the
/// config points into it.
class Settings {
 public:
  Settings();
  Settings(const Settings&) = delete;
  Settings& operator=(const Settings&) = delete;

  Config& config() { return config_; }
  const Config& config() const { return config_; }
  const system::SlamOptions& slam() const { return slam_; }
  adaptation::AdaptationOptions& adaptation() { return adaptation_; }
  void validate() const;

 private:
  system::SlamOptions slam_;
  adaptation::AdaptationOptions adaptation_;
  Config config_;
};

/// A config file as given, or a shipped one by its bare name ("kitti", "paper_euroc"). Throws
/// InputError(kUsage).
std::filesystem::path find_config(const std::string& name);

/// The layers above the defaults, as given on the command line:
/// defaults < --config files in order < environment IMSLAM_* < --set key=value in order.
class ConfigLayers {
 public:
  void add_options(CLI::App& command);

  /// Throws InputError(kUsage) naming file:line or option; validates the result.
  void apply(Settings& settings) const;

 private:
  std::vector<std::string> files_;
  std::vector<std::string> assignments_;
};

}  // namespace imslam::app

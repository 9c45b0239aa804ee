#pragma once

#include <optional>
#include <string>

#include "app/command.hpp"
#include "app/settings.hpp"

namespace imslam::app {

/// What `imslam finetune` is asked for.
struct FinetuneArguments {
  std::string dataset;  ///< folder of a sequence, or a suite
  std::string root;     ///< of the suite's sequences
  std::string format = "auto";
  std::string front_end = "learned";
  std::string imu = "learned";
  std::string out;
  std::string frames;
  std::string networks;
  std::optional<int> epochs;
  int jobs = 1;
  bool resume = false;
  bool force = false;
  bool overwrite = false;
  bool list = false;
  ConfigLayers layers;
};

/// Fine-tunes, in as many processes as were asked for, and records all. Throws InputError.
ExitCode finetune(const FinetuneArguments& arguments, const CommonOptions& common);

}  // namespace imslam::app

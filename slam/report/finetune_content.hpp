#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace imslam::report {

/// What the folder of a finished fine-tuning holds.
struct FinetuneContent {
  std::string name;         ///< of the folder
  nlohmann::json metrics;   ///< metrics.json: see slam/adaptation/finetune_record
  std::string config_yaml;  ///< empty: not there
  std::vector<std::string>
      runs;  ///< zero_shot, adapted (/NAME of several sequences) with a report.html
};

/// A figure of merit of a fine-tuning.
struct Measure {
  const char* key;    ///< in metrics.results and metrics.curves
  const char* label;  ///< for people
  const char* unit;
  const char* color;  ///< name of a variable in template/style.css
};

/// All of them, in the order of tables.
const std::vector<Measure>& finetune_measures();

/// Whether the folder is that of a fine-tuning, finished or not.
bool is_finetuning(const std::filesystem::path& folder);

/// Throws InputError if there is no metrics.json of a fine-tuning.
FinetuneContent read_finetuning(const std::filesystem::path& folder);

/// metrics.curves[key]; NaN where there is no number. Empty if there is no such curve.
std::vector<double> curve(const FinetuneContent& content, const std::string& key);

}  // namespace imslam::report

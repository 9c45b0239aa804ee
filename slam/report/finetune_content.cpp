#include "slam/report/finetune_content.hpp"

#include <limits>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/report/json_text.hpp"

namespace imslam::report {
namespace fs = std::filesystem;

const std::vector<Measure>& finetune_measures() {
  static const std::vector<Measure> kMeasures = {
      {"held_out_loss", "Held-out loss, self-supervised", "", "accent"},
      {"learned_loss", "Learned loss, self-supervised", "", "truth"},
      {"vo_ate_m", "VO: ATE", "m", "vo"},
      {"vo_rpe_m", "VO: RPE per frame", "m", "vo"},
      {"vo_rpe_deg", "VO: RPE per frame", "deg", "vo"},
      {"imu_rotation_deg", "IMU: rotation over 5 s", "deg", "third"},
      {"imu_position_m", "IMU: position over 5 s", "m", "third"},
      {"graph_ate_m", "Graph: ATE", "m", "graph"},
      {"graph_rpe_m", "Graph: RPE per frame", "m", "graph"},
      {"graph_rpe_deg", "Graph: RPE per frame", "deg", "graph"},
  };
  return kMeasures;
}

namespace {

std::vector<std::string> names_of_sequences(const nlohmann::json& metrics) {
  std::vector<std::string> names;
  const auto sequences = metrics.find("sequences");
  if (sequences == metrics.end() || !sequences->is_array()) return names;
  for (const nlohmann::json& sequence : *sequences) names.push_back(text_at(sequence, "name"));
  return names;
}

}  // namespace

bool is_finetuning(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "log.csv", error) && !fs::exists(folder / "trajectory.tum", error);
}

FinetuneContent read_finetuning(const fs::path& folder) {
  std::error_code error;
  const fs::path metrics = folder / "metrics.json";
  if (!fs::exists(metrics, error)) {
    throw InputError(folder.string() +
                     ": the fine-tuning there is not finished; `imslam finetune --resume` goes on");
  }
  FinetuneContent content;
  content.name = fs::weakly_canonical(folder, error).filename().string();
  content.metrics = parse_json(read_file(metrics), metrics.string());
  if (text_at(content.metrics, "kind") != "finetune") {
    throw InputError(metrics.string() + ": expected the metrics of a fine-tuning");
  }
  if (fs::exists(folder / "config.yaml", error)) {
    content.config_yaml = read_file(folder / "config.yaml");
  }
  for (const char* run : {"zero_shot", "adapted"}) {
    if (fs::exists(folder / run / "report.html", error)) content.runs.emplace_back(run);
    for (const std::string& name : names_of_sequences(content.metrics)) {
      const std::string place = std::string(run) + "/" + name;
      if (fs::exists(folder / place / "report.html", error)) content.runs.push_back(place);
    }
  }
  return content;
}

std::vector<double> curve(const FinetuneContent& content, const std::string& key) {
  std::vector<double> values;
  const auto curves = content.metrics.find("curves");
  if (curves == content.metrics.end() || !curves->is_object()) return values;
  const auto column = curves->find(key);
  if (column == curves->end() || !column->is_array()) return values;
  for (const nlohmann::json& value : *column) {
    values.push_back(value.is_number() ? value.get<double>()
                                       : std::numeric_limits<double>::quiet_NaN());
  }
  return values;
}

}  // namespace imslam::report

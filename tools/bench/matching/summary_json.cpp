#include <cmath>
#include <nlohmann/json.hpp>

#include "slam/base/file.hpp"
#include "tools/bench/matching/tables.hpp"

namespace imslam::bench {
namespace {

using nlohmann::json;

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json quality_json(const Quality& quality) {
  return {{"points", quality.points},
          {"coverage", number(quality.coverage)},
          {"median_px", number(quality.median)},
          {"mean_px", number(quality.mean)},
          {"above_3px", number(quality.gross)}};
}

json summary_json(const Summary& s) {
  json row = {{"data", s.data},       {"kind", kind_name(s.kind)},
              {"condition", "clean"}, {"severity", s.trial.severity},
              {"method", s.method},   {"queries", s.queries},
              {"value", nullptr},     {"natural", quality_json(s.natural)}};
  if (s.trial.severity > 0) {
    row["condition"] = s.trial.condition.name;
    row["value"] = s.trial.condition.values.at(static_cast<std::size_t>(s.trial.severity - 1));
  }
  if (s.equal) row["at_klt_coverage"] = quality_json(*s.equal);
  if (s.calibration) {
    row["calibration"] = {{"normalised_median", number(s.calibration->normalised_median)},
                          {"stated_confidence", number(s.calibration->stated)},
                          {"errors_below_2px", number(s.calibration->right)}};
  }
  return row;
}

}  // namespace

void write_json(const std::filesystem::path& file, const std::vector<Summary>& summaries) {
  json rows = json::array();
  for (const Summary& summary : summaries) rows.push_back(summary_json(summary));
  write_file_atomic(file, rows.dump(1) + "\n");
}

}  // namespace imslam::bench

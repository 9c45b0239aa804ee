#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "slam/system/run_evaluation.hpp"
#include "slam/system/slam_result.hpp"

namespace imslam::system {

/// Facts about the run as a whole.
struct RunSummary {
  std::string dataset;
  std::string format;
  double wall_s = 0.0;                 ///< from the first frame to the final trajectory
  std::string networks = "zero-shot";  ///< or how they were adapted to the sequence, and when
  bool stopped = false;                ///< before the last frame that was asked for
};

/// The content of metrics.json. Numbers that are not determined are null; nothing is ever NaN.
nlohmann::json metrics_json(const SlamResult& result,
                            const RunSummary& summary,
                            const std::optional<RunEvaluation>& evaluation);

/// The table that `imslam run` prints from the content of metrics.json: one column per trajectory.
std::string metrics_table(const nlohmann::json& metrics);

}  // namespace imslam::system

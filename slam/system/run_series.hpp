#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "slam/system/run_evaluation.hpp"
#include "slam/system/slam_result.hpp"

namespace imslam::system {

/// The content of series.json: columns of equal length for the plots of the report. Numbers that
/// are not determined are null.
nlohmann::json series_json(const SlamResult& result,
                           const std::optional<RunEvaluation>& evaluation);

}  // namespace imslam::system

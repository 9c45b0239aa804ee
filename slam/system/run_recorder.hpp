#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "slam/sensors/calibration.hpp"
#include "slam/system/run_evaluation.hpp"
#include "slam/system/run_metrics.hpp"
#include "slam/system/slam_result.hpp"

namespace imslam::system {

/// What the manifest says about how a run came about.
struct RunProvenance {
  std::string version;
  std::string git_hash;
  std::vector<std::string> command_line;
  std::uint64_t seed = 0;
  std::string config_yaml;  ///< effective
  std::vector<std::filesystem::path> input_files;
};

/// Networks and their model cards as manifests list them.
nlohmann::json models_json(const std::vector<ModelRecord>& models);

/// Writes the run folder: trajectories, graph.g2o, map.pcd, metrics.json, series.json, config.yaml,
/// manifest.json and report.html. Every file is written all or not. Throws InputError(kOutput).
void record_run(const std::filesystem::path& folder,
                const SlamResult& result,
                const RunSummary& summary,
                const RunProvenance& provenance,
                const StereoCamera& camera,
                const std::optional<RunEvaluation>& evaluation,
                double map_voxel_m);

}  // namespace imslam::system

#include "slam/system/run_recorder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <nlohmann/json.hpp>

#include "datasets/trajectory_file.hpp"
#include "pgo/g2o_file.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/parallel.hpp"
#include "slam/report/report.hpp"
#include "slam/system/library_versions.hpp"
#include "slam/system/run_series.hpp"

namespace imslam::system {
namespace fs = std::filesystem;
namespace {

/// KITTI's convention: poses of the left camera, the first one identity.
Trajectory left_camera(const Trajectory& body, const lie::SE3d& T_body_left) {
  Trajectory left;
  left.frame = "left";
  if (body.size() == 0) return left;
  const lie::SE3d T_left0_world = (body.poses.front() * T_body_left).inverse();
  for (std::size_t i = 0; i < body.size(); ++i) {
    left.add(body.times_ns[i], T_left0_world * body.poses[i] * T_body_left);
  }
  return left;
}

/// What the graph holds of the camera, with what it found: how it is turned, disparities' offset.
MapCamera found_camera(const pgo::GraphData& graph, const StereoCamera& camera) {
  const auto turn = lie::SO3d::exp(graph.globals.camera_rotation);
  return {graph.T_body_left * lie::SE3d(turn, Eigen::Vector3d::Zero()),
          camera.fx * camera.baseline_m, graph.globals.disparity_offset};
}

void write_trajectories(const fs::path& folder,
                        const SlamResult& result,
                        const StereoCamera& camera,
                        const std::optional<RunEvaluation>& evaluation) {
  using datasets::TrajectoryFormat;
  using datasets::write_trajectory;
  write_trajectory(folder / "trajectory.tum", result.graph, TrajectoryFormat::kTum);
  write_trajectory(folder / "trajectory.csv", result.graph, TrajectoryFormat::kEuroc);
  write_trajectory(folder / "trajectory.kitti", left_camera(result.graph, camera.T_body_left),
                   TrajectoryFormat::kKitti);
  write_trajectory(folder / "vo_only.tum", result.vo_only, TrajectoryFormat::kTum);
  if (result.online.size() > 0) {
    write_trajectory(folder / "online.tum", result.online, TrajectoryFormat::kTum);
  }
  if (evaluation && evaluation->truth.size() > 0) {
    write_trajectory(folder / "truth.tum", evaluation->truth, TrajectoryFormat::kTum);
  }
}

nlohmann::json manifest_json(const RunProvenance& provenance,
                             const std::vector<ModelRecord>& models) {
  nlohmann::json inputs = nlohmann::json::array();
  for (const fs::path& file : provenance.input_files) {
    inputs.push_back({{"file", file.string()}, {"sha256", sha256_of_file(file)}});
  }
  return {{"program", provenance.version},
          {"git_hash", provenance.git_hash},
          {"time", fmt::format("{:%Y-%m-%dT%H:%M:%S%z}", fmt::localtime(std::time(nullptr)))},
          {"command_line", provenance.command_line},
          {"seed", provenance.seed},
          {"threads", thread_count()},
          {"libraries", library_versions()},
          {"config_sha256", sha256(provenance.config_yaml)},
          {"models", models_json(models)},
          {"inputs", inputs}};
}

void write_json(const fs::path& file, const nlohmann::json& json, int indent) {
  // Paths may hold bytes that are not UTF-8; JSON may not.
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
  write_file_atomic(file, json.dump(indent, ' ', false, kReplace) + "\n");
}

}  // namespace

nlohmann::json models_json(const std::vector<ModelRecord>& models) {
  nlohmann::json list = nlohmann::json::array();
  for (const ModelRecord& model : models) {
    const nn::ModelCard& card = model.card;
    list.push_back({{"name", model.name},
                    {"file", model.file},
                    {"sha256", card.sha256},
                    {"what", card.what},
                    {"data", card.data},
                    {"command", card.command},
                    {"seed", card.seed},
                    {"metrics", card.metrics},
                    {"limits", card.limits},
                    {"parent", card.parent}});
  }
  return list;
}

void record_run(const fs::path& folder,
                const SlamResult& result,
                const RunSummary& summary,
                const RunProvenance& provenance,
                const StereoCamera& camera,
                const std::optional<RunEvaluation>& evaluation,
                double map_voxel_m) {
  write_trajectories(folder, result, camera, evaluation);
  pgo::write_g2o(result.graph_data, folder / "graph.g2o");
  result.map.write_pcd(folder / "map.pcd", result.graph, found_camera(result.graph_data, camera),
                       map_voxel_m);
  write_file_atomic(folder / "config.yaml", provenance.config_yaml);
  write_json(folder / "metrics.json", metrics_json(result, summary, evaluation), 2);
  write_json(folder / "series.json", series_json(result, evaluation), -1);
  write_json(folder / "manifest.json", manifest_json(provenance, result.models), 2);
  report::write_report(folder);
}

}  // namespace imslam::system

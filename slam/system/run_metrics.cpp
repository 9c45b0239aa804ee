#include "slam/system/run_metrics.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "slam/base/time.hpp"
#include "slam/evaluation/evaluation_text.hpp"
#include "slam/system/flagged_segments.hpp"
#include "slam/system/json_number.hpp"
#include "slam/system/resources.hpp"

namespace imslam::system {
namespace {

using Json = nlohmann::json;

Json error_block(const evaluation::Evaluation& e) {
  Json block = Json::parse(evaluation::as_json(e).dump());  // ordered there, sorted here
  if (!e.sub_trajectories.segments.empty()) {
    block["sub_t_rel_percent"] = number(e.sub_trajectories.t_rel_percent);
    block["sub_r_rel_deg_per_100m"] = number(e.sub_trajectories.r_rel_deg_per_100m);
  }
  return block;
}

Json consistency_block(const evaluation::MotionConsistency& c) {
  return {{"motions", c.motions},
          {"nees_mean", number(c.nees_mean)},
          {"nees_median", number(c.nees_median)},
          {"nees_translation_mean", number(c.nees_translation_mean)},
          {"nees_rotation_mean", number(c.nees_rotation_mean)},
          {"share_inside_95", number(c.share_inside)}};
}

Json vector3(const Eigen::Vector3d& v) { return {number(v.x()), number(v.y()), number(v.z())}; }

Json rows_of(const Eigen::Matrix3d& m) {
  return {vector3(m.row(0)), vector3(m.row(1)), vector3(m.row(2))};
}

Json calibration_block(const SlamResult& result) {
  Json block = {{"disparity_offset_px", number(result.disparity_offset_px.value)},
                {"disparity_offset_sigma_px", number(result.disparity_offset_px.sigma)}};
  if (result.focal_error) {
    block["focal_error"] = number(result.focal_error->value);
    block["focal_error_sigma"] = number(result.focal_error->sigma);
  }
  if (result.camera_rotation) {
    block["camera_rotation_rad"] = vector3(result.camera_rotation->value);
    if (result.camera_rotation->sigma) {
      block["camera_rotation_sigma_rad"] = vector3(*result.camera_rotation->sigma);
    }
  }
  if (result.gyro_shape) {
    block["gyro_shape"] = rows_of(result.gyro_shape->value);
    if (result.gyro_shape->sigma) block["gyro_shape_sigma"] = rows_of(*result.gyro_shape->sigma);
  }
  if (result.time_offset_s) {
    block["time_offset_s"] = number(result.time_offset_s->value);
    block["time_offset_sigma_s"] = number(result.time_offset_s->sigma);
  }
  if (result.inertial && !result.graph_data.states.empty()) {
    const ImuBias& bias = result.graph_data.states.back().bias;
    block["gyro_bias"] = vector3(bias.gyro);
    block["accel_bias"] = vector3(bias.accel);
    block["gravity_m_s2"] = number(result.gravity_m_s2);
  }
  return block;
}

Json timing_block(const StageTimer& timing) {
  Json block = Json::object();
  for (const auto& [stage, s] : timing.summaries()) {
    block[stage] = {{"mean", s.mean_ms}, {"p50", s.p50_ms}, {"p99", s.p99_ms}, {"max", s.max_ms}};
  }
  return block;
}

Json counter_block(const Counters& c) {
  return {{"frames_missing", c.frames_missing}, {"frames_degraded", c.frames_degraded},
          {"vo_failures", c.vo_failures},       {"skip_edges", c.skip_edges},
          {"loop_edges", c.loop_edges},         {"imu_samples", c.imu_samples},
          {"imu_dropped", c.imu_dropped},       {"imu_gaps", c.imu_gaps}};
}

Json segment_list(const SlamResult& result) {
  Json list = Json::array();
  const auto& times_ns = result.graph.times_ns;
  for (const FlaggedSegment& segment : flagged_segments(result.series)) {
    if (segment.last >= times_ns.size()) continue;
    list.push_back({{"kind", segment.kind},
                    {"frames", segment.last - segment.first + 1},
                    {"from_s", to_seconds(times_ns[segment.first] - times_ns.front())},
                    {"to_s", to_seconds(times_ns[segment.last] - times_ns.front())}});
  }
  return list;
}

double path_length(const Trajectory& trajectory) {
  double length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory.poses[i].translation() - trajectory.poses[i - 1].translation()).norm();
  }
  return length;
}

double duration_s(const Trajectory& trajectory) {
  return trajectory.size() < 2 ? 0.0
                               : to_seconds(trajectory.times_ns.back() - trajectory.times_ns[0]);
}

}  // namespace

Json metrics_json(const SlamResult& result,
                  const RunSummary& summary,
                  const std::optional<RunEvaluation>& evaluation) {
  const auto frames = static_cast<double>(result.counters.frames);
  const auto poses = static_cast<double>(result.graph.size());
  Json metrics = {
      {"dataset", summary.dataset},
      {"format", summary.format},
      {"networks", summary.networks},
      {"frames", result.counters.frames},
      {"stopped", summary.stopped},
      {"coverage", frames > 0 ? poses / frames : 0.0},
      {"frames_per_second", summary.wall_s > 0 ? frames / summary.wall_s : 0.0},
      {"peak_memory_mb", peak_memory_mb()},
      {"duration_s", duration_s(result.graph)},
      {"path_length_m", number(path_length(result.graph))},
      {"inertial", result.inertial},
      {"calibration", calibration_block(result)},
      {"counters", counter_block(result.counters)},
      {"segments", segment_list(result)},
      {"timing_ms", timing_block(result.timing)},
      {"solver",
       {{"converged", result.solve.converged},
        {"iterations", result.solve.iterations},
        {"cost", number(result.solve.cost)},
        {"cost_per_residual", number(result.solve.cost / std::max(1, result.solve.residuals))},
        {"reason", result.solve.reason}}},
      {"warnings", result.warnings}};
  if (evaluation) {
    metrics["vo"] = error_block(evaluation->vo);
    if (evaluation->vo_consistency) {
      metrics["vo"]["consistency"] = consistency_block(*evaluation->vo_consistency);
    }
    metrics["graph"] = error_block(evaluation->graph);
    if (evaluation->online) metrics["online"] = error_block(*evaluation->online);
    for (const std::string& warning : evaluation->graph.warnings) {
      metrics["warnings"].push_back("evaluation: " + warning);
    }
  }
  return metrics;
}

}  // namespace imslam::system

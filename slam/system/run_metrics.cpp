#include "slam/system/run_metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "slam/base/time.hpp"
#include "slam/evaluation/evaluation_text.hpp"
#include "slam/system/flagged_segments.hpp"
#include "slam/system/resources.hpp"

namespace imslam::system {
namespace {

using Json = nlohmann::json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

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

Json calibration_block(const SlamResult& result) {
  Json block = {{"disparity_offset_px", number(result.disparity_offset_px.value)},
                {"disparity_offset_sigma_px", number(result.disparity_offset_px.sigma)}};
  if (result.focal_error) {
    block["focal_error"] = number(result.focal_error->value);
    block["focal_error_sigma"] = number(result.focal_error->sigma);
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

template <typename Values>
Json column(const Values& values) {
  Json list = Json::array();
  for (const auto value : values) list.push_back(number(static_cast<double>(value)));
  return list;
}

/// Errors of the matched poses, spread over all frames (null where nothing matched).
Json error_column(const evaluation::Evaluation& e,
                  const std::vector<double>& errors,
                  const Trajectory& trajectory,
                  double factor) {
  constexpr double kTolerance = 0.02;  // [s] evo pairs within 0.01 s
  Json list = Json::array();
  std::size_t next = 0;
  for (const std::int64_t time_ns : trajectory.times_ns) {
    const double time_s = static_cast<double>(time_ns) / kNanosecondsPerSecond;
    while (next < errors.size() && e.poses.times_s[next] < time_s - kTolerance) ++next;
    const bool matched = next < errors.size() && e.poses.times_s[next] <= time_s + kTolerance;
    list.push_back(matched ? number(errors[next] * factor) : Json(nullptr));
    if (matched) ++next;
  }
  return list;
}

Json box_lists(const ErrorsByLength& errors) {
  Json lists = Json::object();
  for (const auto& [length, values] : errors) lists[std::to_string(length)] = column(values);
  return lists;
}

void add_state_columns(const SlamResult& result, Json& columns) {
  if (!result.inertial) return;
  std::array<std::vector<double>, 7> values;
  for (const pgo::State& state : result.graph_data.states) {
    values[0].push_back(state.nav.v_world.norm());
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      values.at(1 + i).push_back(state.bias.gyro(axis));
      values.at(4 + i).push_back(state.bias.accel(axis));
    }
  }
  constexpr std::array<const char*, 7> kNames = {"speed_m_s",   "gyro_bias_x",  "gyro_bias_y",
                                                 "gyro_bias_z", "accel_bias_x", "accel_bias_y",
                                                 "accel_bias_z"};
  for (std::size_t i = 0; i < kNames.size(); ++i) columns[kNames.at(i)] = column(values.at(i));
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

Json series_json(const SlamResult& result, const std::optional<RunEvaluation>& evaluation) {
  Json columns = Json::object();
  Json times = Json::array();
  for (const std::int64_t time_ns : result.graph.times_ns) {
    times.push_back(to_seconds(time_ns - result.graph.times_ns.front()));
  }
  columns["time_s"] = std::move(times);
  columns["inliers"] = column(result.series.inliers);
  columns["degraded"] = column(result.series.degraded);
  if (!result.series.imu_gap.empty()) columns["imu_gap"] = column(result.series.imu_gap);
  if (!result.series.conflict.empty()) columns["conflict"] = column(result.series.conflict);
  columns["frame_ms"] = column(result.series.frame_ms);
  columns["memory_mb"] = column(result.series.memory_mb);
  if (!result.series.position_sigma_m.empty()) {
    columns["position_sigma_m"] = column(result.series.position_sigma_m);
  }
  add_state_columns(result, columns);
  Json series = {{"columns", std::move(columns)}};
  if (evaluation) {
    constexpr double kDegrees = 180.0 / 3.14159265358979323846;
    for (const auto& [name, e] :
         {std::pair("graph", &evaluation->graph), std::pair("vo", &evaluation->vo)}) {
      auto& into = series["columns"];
      into[fmt::format("{}_error_m", name)] =
          error_column(*e, e->poses.position_m, result.graph, 1.0);
      into[fmt::format("{}_error_deg", name)] =
          error_column(*e, e->poses.rotation_rad, result.graph, kDegrees);
    }
    series["rpe"] = {{"vo", box_lists(evaluation->vo_by_length)},
                     {"graph", box_lists(evaluation->graph_by_length)}};
  }
  return series;
}

namespace {

/// What was found out about the calibration, a line each, with standard deviations where known.
std::string calibration_lines(const Json& calibration) {
  struct Line {
    const char* key;
    const char* sigma_key;
    const char* label;
    double factor;
    int digits;
  };
  constexpr std::array<Line, 3> kLines = {
      {{"disparity_offset_px", "disparity_offset_sigma_px", "Disparity offset [px]", 1.0, 3},
       {"focal_error", "focal_error_sigma", "Focal length, error [%]", 100.0, 3},
       {"time_offset_s", "time_offset_sigma_s", "Time offset [ms]", 1000.0, 2}}};
  std::string text;
  for (const Line& line : kLines) {
    const Json value = calibration.value(line.key, Json());
    const Json sigma = calibration.value(line.sigma_key, Json());
    if (value.is_null()) continue;
    text +=
        fmt::format("{:<28}{:>12.{}f}", line.label, line.factor * value.get<double>(), line.digits);
    if (!sigma.is_null()) {
      text += fmt::format(" +- {:.{}f}", line.factor * sigma.get<double>(), line.digits);
    }
    text += "\n";
  }
  return text;
}

}  // namespace

std::string metrics_table(const Json& metrics) {
  struct Row {
    const char* key;
    const char* label;
    int digits;
  };
  constexpr std::array<Row, 9> kRows = {{{"ate_se3_rmse_m", "ATE, SE3 aligned [m]", 4},
                                         {"ate_posyaw_rmse_m", "ATE, position+yaw [m]", 4},
                                         {"rpe_1m_rmse_m", "RPE over 1 m [m]", 4},
                                         {"rpe_frame_rmse_m", "RPE per frame [m]", 5},
                                         {"rpe_frame_rmse_deg", "RPE per frame [deg]", 4},
                                         {"t_rel_percent", "KITTI t_rel [%]", 3},
                                         {"r_rel_deg_per_100m", "KITTI r_rel [deg/100 m]", 3},
                                         {"rotation_end_deg", "Rotation at the end [deg]", 3},
                                         {"end_error_percent", "End error [% of path]", 3}}};
  std::string table = fmt::format(
      "{}: {} frames, {:.1f} m in {:.1f} s, {:.1f} frames/s, coverage {:.1f} %\n",
      metrics.at("dataset").get<std::string>(), metrics.at("frames").get<int>(),
      metrics.at("path_length_m").get<double>(), metrics.at("duration_s").get<double>(),
      metrics.at("frames_per_second").get<double>(), 100.0 * metrics.at("coverage").get<double>());
  table += calibration_lines(metrics.value("calibration", Json::object()));
  if (!metrics.contains("graph")) return table + "no ground truth: no errors to report\n";
  std::vector<std::string> columns = {"vo", "graph"};
  if (metrics.contains("online")) columns.emplace_back("online");
  table += fmt::format("{:<28}", "");
  for (const std::string& name : columns) table += fmt::format("{:>12}", name);
  table += "\n";
  for (const Row& row : kRows) {
    table += fmt::format("{:<28}", row.label);
    for (const std::string& name : columns) {
      const Json& value = metrics.at(name).at(row.key);
      table += value.is_null() ? fmt::format("{:>12}", "-")
                               : fmt::format("{:>12.{}f}", value.get<double>(), row.digits);
    }
    table += "\n";
  }
  return table;
}

}  // namespace imslam::system

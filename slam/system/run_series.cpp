#include "slam/system/run_series.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "slam/base/time.hpp"
#include "slam/system/json_number.hpp"

namespace imslam::system {
namespace {

using Json = nlohmann::json;

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

}  // namespace imslam::system

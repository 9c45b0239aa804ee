#include "slam/report/page_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "slam/base/error.hpp"
#include "slam/base/text.hpp"
#include "slam/base/time.hpp"
#include "slam/report/html_text.hpp"
#include "slam/report/json_text.hpp"
#include "slam/report/thinning.hpp"

namespace imslam::report {
namespace {

using nlohmann::json;

/// Stamps and positions count from the first pose of the first trajectory that there is: then
/// float32 resolves them.
struct Origin {
  std::int64_t time_ns = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

Origin origin_of(const RunContent& run) {
  for (const Trajectory* trajectory : {&run.graph, &run.vo, &run.truth}) {
    if (trajectory->size() == 0) continue;
    return {trajectory->times_ns.front(), trajectory->poses.front().translation()};
  }
  return {};
}

json trajectory_json(const Trajectory& trajectory, const Origin& origin) {
  std::vector<float> time;
  std::vector<float> position;
  std::vector<float> rotation;
  for (const std::size_t i : spread(trajectory.size(), kMaxRows)) {
    time.push_back(static_cast<float>(to_seconds(trajectory.times_ns[i] - origin.time_ns)));
    const Eigen::Vector3d p = trajectory.poses[i].translation() - origin.position;
    const Eigen::Vector4d q = trajectory.poses[i].rotation().quaternion().coeffs();
    for (Eigen::Index k = 0; k < 3; ++k) position.push_back(static_cast<float>(p[k]));
    for (Eigen::Index k = 0; k < 4; ++k) rotation.push_back(static_cast<float>(q[k]));
  }
  return {{"count", time.size()},
          {"time", base64(time)},
          {"position", base64(position)},
          {"rotation", base64(rotation)}};
}

json map_json(const PointCloud& map, const Origin& origin) {
  Eigen::Vector3f low = map.points.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& p : map.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3d center = 0.5 * (low.cast<double>() + high.cast<double>());
  const double scale = std::max(1e-9, 0.5 * (high - low).cast<double>().maxCoeff()) / 32767.0;
  std::vector<std::int16_t> points;
  for (const Eigen::Vector3f& p : map.points) {
    const Eigen::Vector3d cell = (p.cast<double>() - center) / scale;
    for (Eigen::Index k = 0; k < 3; ++k) {
      points.push_back(
          static_cast<std::int16_t>(std::clamp(std::lround(cell[k]), -32767L, 32767L)));
    }
  }
  std::vector<std::uint8_t> intensity;
  for (const float value : map.intensities) {
    intensity.push_back(static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F)));
  }
  const Eigen::Vector3d offset = center - origin.position;
  return {{"count", map.points.size()},
          {"total", map.total},
          {"center", {offset.x(), offset.y(), offset.z()}},
          {"scale", scale},
          {"points", base64(points)},
          {"intensity", intensity.empty() ? json() : json(base64(intensity))}};
}

/// The numbers of a JSON array; null, texts and what float32 cannot hold become NaN.
std::vector<double> numbers(const json& array) {
  std::vector<double> values;
  for (const json& entry : array) {
    const double value = entry.is_number() ? entry.get<double>() : std::nan("");
    const bool holds = std::abs(value) < static_cast<double>(std::numeric_limits<float>::max());
    values.push_back(holds ? value : std::nan(""));
  }
  return values;
}

json series_json(const json& series, std::vector<std::string>& notes) {
  json out = json::object();
  const auto columns = series.find("columns");
  if (columns == series.end() || !columns->is_object()) return out;
  const auto time = columns->find("time_s");
  if (time == columns->end() || !time->is_array()) {
    notes.emplace_back("series.json has no column time_s: no plots over time are shown.");
    return out;
  }
  for (const auto& [name, column] : columns->items()) {
    if (!column.is_array() || column.size() != time->size()) {
      notes.push_back(fmt::format("series.json: column {} is left out, expected {} values.", name,
                                  time->size()));
      continue;
    }
    const Extreme keep = name == "time_s"    ? Extreme::kFirst
                         : name == "inliers" ? Extreme::kSmallest
                                             : Extreme::kLargestMagnitude;
    out[name] = base64(thin(numbers(column), kMaxRows, keep));
  }
  return out;
}

json box_json(const json& samples) {
  std::vector<double> values = numbers(samples);
  values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return !(v == v); }),
               values.end());
  if (values.empty()) return {};
  const BoxSummary box = box_summary(std::move(values));
  return {{"low", box.low},   {"q1", box.q1},   {"median", box.median}, {"q3", box.q3},
          {"high", box.high}, {"max", box.max}, {"rmse", box.rmse},     {"count", box.count}};
}

json rpe_json(const json& series) {
  json rows = json::array();
  const auto rpe = series.find("rpe");
  if (rpe == series.end() || !rpe->is_object()) return rows;
  std::vector<std::pair<double, std::string>> lengths;
  for (const auto& [estimate, groups] : rpe->items()) {
    if (!groups.is_object()) continue;
    for (const auto& [key, samples] : groups.items()) {
      const double length = parse_double(key).value_or(std::nan(""));
      if (samples.is_array() && std::isfinite(length)) lengths.emplace_back(length, key);
    }
  }
  std::sort(lengths.begin(), lengths.end());
  lengths.erase(std::unique(lengths.begin(), lengths.end()), lengths.end());
  for (const auto& [length, key] : lengths) {
    json row = {{"length_m", length}};
    for (const char* estimate : {"graph", "vo"}) {
      if (!rpe->contains(estimate) || !(*rpe)[estimate].contains(key)) continue;
      row[estimate] = box_json((*rpe)[estimate][key]);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

json object_of(const std::string& text, const std::string& name, std::vector<std::string>& notes) {
  if (text.empty()) return json::object();
  try {
    json value = parse_json(text, name);
    if (value.is_object()) return value;
    notes.push_back(name + " was left out: expected an object.");
  } catch (const InputError& problem) {
    notes.push_back(std::string("left out: ") + problem.what());
  }
  return json::object();
}

std::string date_of(const json& manifest) {
  for (const char* key : {"started", "date", "time", "created"}) {
    const std::string date = text_at(manifest, key);
    if (!date.empty()) return date;
  }
  return "";
}

}  // namespace

PageData page_data(const RunContent& run) {
  PageData page;
  page.notes = run.notes;
  const json metrics = object_of(run.metrics_json, "metrics.json", page.notes);
  const json series = object_of(run.series_json, "series.json", page.notes);
  std::vector<std::string> unused;  // the manifest is shown as text, broken or not
  page.date = date_of(object_of(run.manifest_json, "manifest.json", unused));
  page.dataset = text_at(metrics, "dataset");
  if (page.dataset.empty()) page.dataset = run.name;

  const Origin origin = origin_of(run);
  json out = {{"name", run.name}, {"dataset", page.dataset}, {"date", page.date}};
  out["metrics"] = metrics;
  out["origin"] = {origin.position.x(), origin.position.y(), origin.position.z()};
  out["trajectories"] = json::object();
  const std::array<std::pair<const char*, const Trajectory*>, 3> trajectories = {
      {{"graph", &run.graph}, {"vo", &run.vo}, {"truth", &run.truth}}};
  for (const auto& [name, trajectory] : trajectories) {
    if (trajectory->size() > 0) out["trajectories"][name] = trajectory_json(*trajectory, origin);
  }
  out["map"] = run.map.points.empty() ? json() : map_json(run.map, origin);
  out["series"] = series_json(series, page.notes);
  out["rpe"] = rpe_json(series);
  out["notes"] = page.notes;
  page.json = out.dump(-1, ' ', false, json::error_handler_t::replace);
  return page;
}

}  // namespace imslam::report

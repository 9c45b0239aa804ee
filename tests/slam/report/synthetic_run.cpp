#include "synthetic_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "slam/base/random.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::report::testing {
namespace {

using nlohmann::json;

constexpr double kRate = 20.0;
constexpr double kPi = 3.14159265358979323846;
constexpr double kStart = 1403636579.75;  ///< [s]

lie::SE3d true_pose(double t, double scale) {
  const double w = 2 * kPi / 30.0;
  const Eigen::Vector3d p(2.6 * std::sin(w * t), 1.7 * std::sin(2 * w * t + 0.4),
                          1.3 + 0.45 * std::sin(3 * w * t));
  const double yaw = 1.1 * w * t + 0.3 * std::sin(5 * w * t);
  const lie::SO3d level = lie::SO3d::exp({0.0, 0.0, yaw});
  const lie::SO3d tilt =
      lie::SO3d::exp({0.12 * std::sin(7 * w * t), 0.1 * std::cos(6 * w * t), 0.0});
  return {level * tilt, p.cwiseProduct(Eigen::Vector3d(scale, scale, std::sqrt(scale)))};
}

struct Worlds {
  std::vector<double> time_s;
  std::vector<lie::SE3d> truth, vo, graph;
};

Worlds make_worlds(const SyntheticRun& options) {
  Worlds out;
  Random random(7);
  Eigen::Matrix<double, 6, 1> vo_drift = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> graph_drift = vo_drift;
  for (int i = 0; i < options.frames; ++i) {
    const double t = i / kRate;
    const lie::SE3d pose = true_pose(t, options.length_scale);
    for (Eigen::Index k = 0; k < 3; ++k) {
      vo_drift[k] += 2.2e-3 * options.length_scale * random.normal();
      vo_drift[k + 3] += 4e-4 * random.normal();
      graph_drift[k] = 0.995 * graph_drift[k] + 5e-4 * options.length_scale * random.normal();
      graph_drift[k + 3] = 0.998 * graph_drift[k + 3] + 4e-5 * random.normal();
    }
    out.time_s.push_back(t);
    out.truth.push_back(pose);
    out.vo.push_back(pose * lie::SE3d::exp(vo_drift));
    out.graph.push_back(pose * lie::SE3d::exp(graph_drift));
  }
  return out;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

void write_tum(const std::filesystem::path& file,
               const Worlds& worlds,
               const std::vector<lie::SE3d>& poses) {
  std::string text = "# seconds tx ty tz qx qy qz qw\n";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d& p = poses[i].translation();
    const auto& q = poses[i].rotation().quaternion();
    text += fmt::format("{:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                        kStart + worlds.time_s[i], p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
  }
  write_text(file, text);
}

double rotation_error_deg(const lie::SE3d& a, const lie::SE3d& b) {
  return (a.rotation().inverse() * b.rotation()).log().norm() * 180 / kPi;
}

double position_error(const lie::SE3d& a, const lie::SE3d& b) {
  return (a.translation() - b.translation()).norm();
}

double path_length(const std::vector<lie::SE3d>& poses) {
  double length = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) length += position_error(poses[i - 1], poses[i]);
  return length;
}

/// Errors of all relative motions over `length` metres of path.
std::vector<double> relative_errors(const Worlds& worlds,
                                    const std::vector<lie::SE3d>& estimate,
                                    double length) {
  std::vector<double> errors;
  std::size_t j = 0;
  double travelled = 0.0;
  for (std::size_t i = 0; i < estimate.size(); i += 5) {
    if (j <= i) {
      j = i;
      travelled = 0.0;
    }
    for (; j + 1 < estimate.size() && travelled < length; ++j)
      travelled += position_error(worlds.truth[j], worlds.truth[j + 1]);
    if (travelled < length) break;
    const lie::SE3d e = (worlds.truth[i].inverse() * worlds.truth[j]).inverse() *
                        (estimate[i].inverse() * estimate[j]);
    errors.push_back(e.translation().norm());
    for (std::size_t k = i; k < i + 5; ++k)
      travelled -= position_error(worlds.truth[k], worlds.truth[k + 1]);
  }
  return errors;
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(values.size(), 1)));
}

json errors_json(const Worlds& worlds, const std::vector<lie::SE3d>& estimate, double scale) {
  std::vector<double> position;
  for (std::size_t i = 0; i < estimate.size(); ++i)
    position.push_back(position_error(worlds.truth[i], estimate[i]));
  const double end = position.back() / path_length(worlds.truth) * 100;
  return {{"ate_se3_rmse_m", rms(position)},
          {"ate_posyaw_rmse_m", rms(position) * 1.04},
          {"rpe_1m_rmse_m", rms(relative_errors(worlds, estimate, scale))},
          {"rpe_frame_rmse_m", rms(position) * 0.04},
          {"rpe_frame_rmse_deg", 0.021},
          {"t_rel_percent", nullptr},
          {"r_rel_deg_per_100m", nullptr},
          {"end_error_percent", end},
          {"rotation_end_deg", rotation_error_deg(worlds.truth.back(), estimate.back())}};
}

json stage(double mean) {
  return {{"mean", mean}, {"p50", mean * 0.96}, {"p99", mean * 1.9}, {"max", mean * 3.4}};
}

void write_metrics(const std::filesystem::path& folder,
                   const SyntheticRun& options,
                   const Worlds& worlds) {
  json metrics = {{"dataset", options.dataset},
                  {"format", "EuRoC"},
                  {"frames", options.frames},
                  {"coverage", 0.9975},
                  {"frames_per_second", 57.3},
                  {"peak_memory_mb", 412.6},
                  {"duration_s", options.frames / kRate},
                  {"path_length_m", path_length(worlds.truth)}};
  if (options.truth) {
    metrics["vo"] = errors_json(worlds, worlds.vo, options.length_scale);
    metrics["graph"] = errors_json(worlds, worlds.graph, options.length_scale);
  }
  metrics["calibration"] = {{"disparity_offset_px", 0.214},
                            {"disparity_offset_sigma_px", 0.012},
                            {"time_offset_s", -0.00318},
                            {"time_offset_sigma_s", 0.00021},
                            {"gravity_m_s2", 9.8071},
                            {"gyro_bias", {-0.0023, 0.0241, 0.0781}},
                            {"accel_bias", {-0.013, 0.116, 0.0634}}};
  metrics["counters"] = {{"frames_missing", 3},
                         {"frames_degraded", 41},
                         {"vo_failures", 2},
                         {"imu_gaps", 1},
                         {"imu_samples_dropped", 12}};
  metrics["timing_ms"] = {{"decode", stage(4.1)},          {"rectify", stage(1.6)},
                          {"matcher", stage(7.9)},         {"pose_layer", stage(0.8)},
                          {"preintegration", stage(0.05)}, {"back_end", stage(3.2)}};
  metrics["warnings"] = {
      "IMU gap of 112 ms at 34.20 s was bridged; the covariance is inflated there.",
      "3 right images are missing; first: cam1/data/1403636581313555456.png"};
  write_text(folder / "metrics.json", metrics.dump(2));
}

void write_series(const std::filesystem::path& folder,
                  const SyntheticRun& options,
                  const Worlds& worlds) {
  Random random(11);
  json columns;
  for (std::size_t i = 0; i < worlds.time_s.size(); ++i) {
    const double t = worlds.time_s[i];
    const bool degraded = (t > 34.0 && t < 36.0) || (t > 51.2 && t < 51.5);
    columns["time_s"].push_back(t);
    if (options.truth) {
      columns["graph_error_m"].push_back(position_error(worlds.truth[i], worlds.graph[i]));
      columns["vo_error_m"].push_back(position_error(worlds.truth[i], worlds.vo[i]));
      columns["graph_error_deg"].push_back(rotation_error_deg(worlds.truth[i], worlds.graph[i]));
      columns["vo_error_deg"].push_back(rotation_error_deg(worlds.truth[i], worlds.vo[i]));
    }
    if (degraded) {
      columns["inliers"].push_back(nullptr);
    } else {
      columns["inliers"].push_back(std::round(185 + 40 * std::sin(0.4 * t) + 14 * random.normal()));
    }
    columns["position_sigma_m"].push_back(
        options.length_scale * (0.004 + 0.003 * std::sqrt(t / 60) + (degraded ? 0.004 : 0.0)));
    const double dt = 0.01;
    columns["speed_m_s"].push_back(position_error(true_pose(t + dt, options.length_scale),
                                                  true_pose(t, options.length_scale)) /
                                   dt);
    const char* axes[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k) {
      const double wave = std::sin(0.05 * t + 2 * k);
      columns[std::string("gyro_bias_") + axes[k]].push_back(-0.002 + 0.026 * k + 4e-4 * wave);
      columns[std::string("accel_bias_") + axes[k]].push_back(-0.01 + 0.05 * k + 0.01 * wave);
    }
    columns["frame_ms"].push_back(14.0 + 2.5 * random.normal() +
                                  (random.chance(0.01) ? 22.0 : 0.0) + 3 * std::sin(0.3 * t));
    columns["memory_mb"].push_back(388.0 + 0.4 * t + (t > 20 ? 6 : 0));
    columns["degraded"].push_back(degraded ? 1 : 0);
  }
  json series = {{"columns", columns}};
  for (const double length : {1.0, 2.0, 5.0, 10.0}) {
    if (!options.truth) break;
    const std::string key = fmt::format("{}", length * options.length_scale);
    series["rpe"]["graph"][key] =
        relative_errors(worlds, worlds.graph, length * options.length_scale);
    series["rpe"]["vo"][key] = relative_errors(worlds, worlds.vo, length * options.length_scale);
  }
  write_text(folder / "series.json", series.dump());
}

/// A point on a wall, the floor or one of a few boxes.
Eigen::Vector3d surface_point(Random& random) {
  const Eigen::Vector3d half(4.2, 3.1, 1.5);
  const double kind = random.uniform();
  Eigen::Vector3d p{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  if (kind < 0.22) {
    p.z() = -1;
  } else if (kind < 0.75) {
    p[kind < 0.45 ? 0 : 1] = random.chance(0.5) ? 1 : -1;
  } else {
    const std::int64_t box = random.integer(0, 3);
    const Eigen::Vector3d center(box < 2 ? 0.72 : -0.72, box % 2 == 0 ? 0.7 : -0.7, -0.65);
    p[random.integer(0, 2)] = random.chance(0.5) ? 1 : -1;
    p = center + p.cwiseProduct(Eigen::Vector3d(0.14, 0.18, 0.35));
  }
  return p.cwiseProduct(half) + Eigen::Vector3d(0, 0, 1.5);
}

void write_map(const std::filesystem::path& file, double scale) {
  Random random(3);
  const std::size_t count = 48000;
  std::string text = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 "
      "4\nTYPE F F F F\n"
      "COUNT 1 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n",
      count);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d p = surface_point(random);
    const double tiles = std::sin(3.1 * p.x()) * std::sin(3.7 * p.y()) * std::cos(4.3 * p.z());
    const Eigen::Vector3d noisy = p + 0.012 * random.normal3();
    const float record[4] = {static_cast<float>(scale * noisy.x()),
                             static_cast<float>(scale * noisy.y()),
                             static_cast<float>(std::sqrt(scale) * noisy.z()),
                             static_cast<float>(std::max(
                                 0.0, std::min(255.0, 128 + 90 * tiles + 25 * random.normal())))};
    char bytes[sizeof(record)];
    std::memcpy(bytes, record, sizeof(record));
    text.append(bytes, sizeof(bytes));
  }
  write_text(file, text);
}

}  // namespace

void write_synthetic_run(const std::filesystem::path& folder, const SyntheticRun& options) {
  std::filesystem::create_directories(folder);
  const Worlds worlds = make_worlds(options);
  write_tum(folder / "trajectory.tum", worlds, worlds.graph);
  write_tum(folder / "vo_only.tum", worlds, worlds.vo);
  if (options.truth) write_tum(folder / "truth.tum", worlds, worlds.truth);
  write_metrics(folder, options, worlds);
  write_series(folder, options, worlds);
  if (options.map) write_map(folder / "map.pcd", options.length_scale);
  write_text(folder / "config.yaml",
             "pgo:\n  huber: 1.0  # [sigma]\n  window: 12\nvo_net:\n  klt:\n    corners: 300\n    "
             "window_px: 21\n");
  write_text(folder / "manifest.json", json{{"program", "imslam 0.1.0"},
                                            {"git", "ece4ba2"},
                                            {"started", "2025-03-14 15:09:26"},
                                            {"seed", 1},
                                            {"threads", 2}}
                                           .dump(2));
}

}  // namespace imslam::report::testing

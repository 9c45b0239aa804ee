#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "slam/system/run_metrics.hpp"

namespace imslam::system {
namespace {

using Json = nlohmann::json;

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

/// How the scale of each axis of a coarse gyro is off.
std::string scale_line(const Json& calibration) {
  const Json value = calibration.value("gyro_shape", Json());
  if (value.is_null()) return "";
  std::string text = fmt::format("{:<28}", "Gyro, errors of scale [%]");
  const Json sigma = calibration.value("gyro_shape_sigma", Json());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    text += fmt::format("{:>12.3f}", 100.0 * value.at(axis).at(axis).get<double>());
    if (!sigma.is_null()) {
      text += fmt::format(" +- {:.3f}", 100.0 * sigma.at(axis).at(axis).get<double>());
    }
  }
  return text + "\n";
}

/// How the camera is turned about its three axes, where an IMU says so.
std::string rotation_line(const Json& calibration) {
  constexpr double kDegrees = 180.0 / M_PI;
  const Json value = calibration.value("camera_rotation_rad", Json());
  if (value.is_null()) return "";
  std::string text = fmt::format("{:<28}", "Camera turned by [deg]");
  const Json sigma = calibration.value("camera_rotation_sigma_rad", Json());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    text += fmt::format("{:>12.3f}", kDegrees * value.at(axis).get<double>());
    if (!sigma.is_null()) {
      text += fmt::format(" +- {:.3f}", kDegrees * sigma.at(axis).get<double>());
    }
  }
  return text + "\n";
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
  const Json calibration = metrics.value("calibration", Json::object());
  table += calibration_lines(calibration) + rotation_line(calibration) + scale_line(calibration);
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

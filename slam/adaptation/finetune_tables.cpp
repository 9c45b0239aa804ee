#include "slam/adaptation/finetune_tables.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <tuple>

namespace imslam::adaptation {
namespace {

std::string cell(const std::optional<double>& value) {
  return value ? fmt::format("{:.5g}", *value) : "-";
}

std::string change(const std::optional<double>& before, const std::optional<double>& after) {
  if (!before || !after || *before == 0.0) return "-";
  return fmt::format("{:+.1f} %", 100.0 * (*after - *before) / std::abs(*before));
}

}  // namespace

std::string comparison_table(const EpochScores& before, const EpochScores& after) {
  struct Row {
    const char* name;
    std::optional<double> before;
    std::optional<double> after;
  };
  const Row rows[] = {
      {"held-out loss (self-supervised)", before.held_out_loss, after.held_out_loss},
      {"VO: ATE [m]", before.vo_ate_m, after.vo_ate_m},
      {"VO: RPE per frame [m]", before.vo_rpe_m, after.vo_rpe_m},
      {"VO: RPE per frame [deg]", before.vo_rpe_deg, after.vo_rpe_deg},
      {"IMU: rotation over 5 s [deg]", before.imu_rotation_deg, after.imu_rotation_deg},
      {"IMU: position over 5 s [m]", before.imu_position_m, after.imu_position_m},
      {"graph: ATE [m]", before.graph_ate_m, after.graph_ate_m},
      {"graph: RPE per frame [m]", before.graph_rpe_m, after.graph_rpe_m},
      {"graph: RPE per frame [deg]", before.graph_rpe_deg, after.graph_rpe_deg},
  };
  std::string text =
      fmt::format("{:<34}{:>12}{:>12}{:>12}\n", "", "zero-shot", "adapted", "change");
  for (const Row& row : rows) {
    const bool loss = &row == rows;  // its zero means nothing
    text += fmt::format(
        "{:<34}{:>12}{:>12}{:>12}\n", row.name, cell(row.before), cell(row.after),
        loss ? fmt::format("{:+.4f}", *row.after - *row.before) : change(row.before, row.after));
  }
  return text;
}

std::string sequences_table(const FinetuneOutcome& outcome) {
  if (outcome.sequences.size() < 2) return {};
  std::string text = fmt::format("{:<20}{:>16}{:>16}{:>16}{:>16}\n", "change", "VO RPE [m]",
                                 "VO RPE [deg]", "IMU 5 s [deg]", "graph ATE [m]");
  for (const FinetunedSequence& one : outcome.sequences) {
    text += fmt::format("{:<20}{:>16}{:>16}{:>16}{:>16}\n", one.name,
                        change(one.before.vo_rpe_m, one.after.vo_rpe_m),
                        change(one.before.vo_rpe_deg, one.after.vo_rpe_deg),
                        change(one.before.imu_rotation_deg, one.after.imu_rotation_deg),
                        change(one.before.graph_ate_m, one.after.graph_ate_m));
  }
  return text;
}

std::string device_table(const DeviceCalibration& before, const DeviceCalibration& after) {
  constexpr double kDegrees = 180.0 / 3.14159265358979323846;
  const auto rotation = [&](const DeviceCalibration& device) {
    return (kDegrees * device.camera_rotation).eval();
  };
  const std::array<std::tuple<const char*, double, double>, 6> rows{
      {{"device: focal length, error [%]", 100.0 * before.focal_error, 100.0 * after.focal_error},
       {"device: disparity offset [px]", before.disparity_offset_px, after.disparity_offset_px},
       {"device: time offset [ms]", 1e3 * before.time_offset_s, 1e3 * after.time_offset_s},
       {"device: camera turned, x [deg]", rotation(before).x(), rotation(after).x()},
       {"device: camera turned, y [deg]", rotation(before).y(), rotation(after).y()},
       {"device: camera turned, z [deg]", rotation(before).z(), rotation(after).z()}}};
  std::string text;
  for (const auto& [name, old, now] : rows) {
    if (old == now) continue;
    text += fmt::format("{:<34}{:>12.4f}{:>12.4f}\n", name, old, now);
  }
  return text;
}

}  // namespace imslam::adaptation

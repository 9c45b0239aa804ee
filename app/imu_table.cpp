#include "app/imu_table.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "slam/base/text.hpp"
#include "slam/base/time.hpp"

namespace imslam::app {
namespace {

using training::OpenScore;
using Json = nlohmann::ordered_json;

/// Four digits that count, without exponents where they are not needed.
std::string number(double value) {
  const double size = value < 0.0 ? -value : value;
  if (size >= 1e6) return fmt::format("{:.2e}", value);
  const int decimals = size >= 1000.0 ? 0 : size >= 100.0 ? 1 : size >= 10.0 ? 2 : 4;
  return fmt::format("{:.{}f}", value, decimals);
}

std::string text_line(const ImuRow& row) {
  const OpenScore& s = row.score;
  const auto pair = [](double rms, double median) { return number(rms) + " " + number(median); };
  return fmt::format(
      "{:<20} {:>6g} {:>6} {:>5}  {:>16} {:>16} {:>16}  {:>9} {:>9} {:>6.1f} % {:>5.2f}..{:<5.2f} "
      "{:>9}\n",
      row.method, row.window_s, s.windows, s.degraded,
      pair(s.rotation_rms_deg, s.rotation_median_deg), pair(s.velocity_rms, s.velocity_median),
      pair(s.position_rms, s.position_median), number(s.nees), number(s.rotation_nees),
      100.0 * s.inside_95, s.band_low, s.band_high, number(s.negative_log_likelihood));
}

/// Names and values of the columns, for files.
std::vector<std::pair<std::string, double>> figures(const OpenScore& s) {
  return {{"windows", static_cast<double>(s.windows)},
          {"degraded", static_cast<double>(s.degraded)},
          {"rotation_rms_deg", s.rotation_rms_deg},
          {"rotation_median_deg", s.rotation_median_deg},
          {"velocity_rms_m_s", s.velocity_rms},
          {"velocity_median_m_s", s.velocity_median},
          {"position_rms_m", s.position_rms},
          {"position_median_m", s.position_median},
          {"nees_per_dof", s.nees},
          {"rotation_nees_per_dof", s.rotation_nees},
          {"inside_95", s.inside_95},
          {"nees_band_low", s.band_low},
          {"nees_band_high", s.band_high},
          {"negative_log_likelihood", s.negative_log_likelihood}};
}

}  // namespace

std::vector<std::string> describe(const training::InertialLogReading& reading) {
  constexpr double kDegrees = 180.0 / M_PI;
  const auto& log = reading.log;
  const auto& velocity = reading.velocity;
  const double span_s = to_seconds(log.truth.back().time_ns - log.truth.front().time_ns);
  const std::string source = velocity.from_file ? "from the file"
                                                : fmt::format("fitted over +-{:.3f} s, degree {}",
                                                              velocity.polynomial.half_width_s,
                                                              velocity.polynomial.degree);
  return {fmt::format("{} readings, {} true states over {:.1f} s, {} jumps of the truth",
                      log.samples.size(), log.truth.size(), span_s, log.truth_jumps.size()),
          fmt::format("true velocities {}, wrong by at most {:.4f} m/s per axis; gravity is {:.2f} "
                      "+- {:.2f} deg off the truth's vertical",
                      source, velocity.sigma, reading.gravity.tilt * kDegrees,
                      reading.gravity.tilt_sigma * kDegrees)};
}

std::string as_text(const ImuTable& table) {
  std::string text = table.title + "\n";
  for (const std::string& remark : table.remarks) text += "  " + remark + "\n";
  text += fmt::format(
      "{:<20} {:>6} {:>6} {:>5}  {:>16} {:>16} {:>16}  {:>9} {:>9} {:>8} {:>12} {:>9}\n", "",
      "window", "", "left", "rotation [deg]", "velocity [m/s]", "position [m]", "NEES", "NEES",
      "inside", "95 % band", "");
  text += fmt::format(
      "{:<20} {:>6} {:>6} {:>5}  {:>16} {:>16} {:>16}  {:>9} {:>9} {:>8} {:>12} {:>9}\n", "method",
      "[s]", "count", "out", "rms median", "rms median", "rms median", "all / 9", "rot / 3", "95 %",
      "of NEES / 9", "-log p");
  double window_s = table.rows.empty() ? 0.0 : table.rows.front().window_s;
  for (const ImuRow& row : table.rows) {
    if (row.window_s != window_s) text += "\n";
    window_s = row.window_s;
    text += text_line(row);
  }
  return text;
}

std::string as_csv(const std::vector<ImuTable>& tables) {
  std::string text = "log,method,window_s";
  for (const auto& [name, value] : figures({})) text += "," + name;
  text += "\n";
  for (const ImuTable& table : tables) {
    for (const ImuRow& row : table.rows) {
      text += fmt::format("{},{},{}", csv_field(table.title), csv_field(row.method), row.window_s);
      for (const auto& [name, value] : figures(row.score)) text += fmt::format(",{}", value);
      text += "\n";
    }
  }
  return text;
}

std::string as_json(const std::vector<ImuTable>& tables) {
  Json list = Json::array();
  for (const ImuTable& table : tables) {
    Json rows = Json::array();
    for (const ImuRow& row : table.rows) {
      Json entry{{"method", row.method}, {"window_s", row.window_s}};
      for (const auto& [name, value] : figures(row.score)) entry[name] = value;
      entry["windows"] = row.score.windows;
      entry["degraded"] = row.score.degraded;
      rows.push_back(entry);
    }
    list.push_back({{"log", table.title}, {"remarks", table.remarks}, {"rows", rows}});
  }
  return list.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace imslam::app

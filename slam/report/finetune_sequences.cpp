#include "slam/report/finetune_sequences.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "slam/report/finetune_cells.hpp"
#include "slam/report/html_text.hpp"
#include "slam/report/json_text.hpp"

namespace imslam::report {

using nlohmann::json;

namespace {

std::vector<Measure> chosen_measures() {
  constexpr const char* kKeys[] = {"held_out_loss", "vo_rpe_m", "vo_rpe_deg", "imu_rotation_deg",
                                   "graph_ate_m"};
  std::vector<Measure> chosen;
  for (const Measure& measure : finetune_measures()) {
    for (const char* key : kKeys) {
      if (std::string(measure.key) == key) chosen.push_back(measure);
    }
  }
  return chosen;
}

std::string sequence_row(const json& sequence) {
  std::string out = "<tr><th>" + escape_html(text_at(sequence, "name")) + "</th>";
  for (const Measure& measure : chosen_measures()) {
    const double before = number_at(at(sequence, "zero_shot"), measure.key);
    const double after = number_at(at(sequence, "batch_adapted"), measure.key);
    const Change change = change_of(measure, before, after);
    out += fmt::format("<td>{} <span class=\"chip {}\">{}</span></td>", number_text(after),
                       change.kind, escape_html(change.text));
  }
  return out + "</tr>\n";
}

struct DeviceNumber {
  const char* label;
  const char* key;
  int axis;  ///< of a vector; -1: a number
  double unit;
};

constexpr double kDegrees = 180.0 / 3.14159265358979323846;
constexpr DeviceNumber kDeviceNumbers[] = {
    {"Focal length, error <small>%</small>", "focal_error", -1, 100.0},
    {"Disparity offset <small>px</small>", "disparity_offset_px", -1, 1.0},
    {"Time offset of the IMU <small>ms</small>", "time_offset_s", -1, 1e3},
    {"Camera turned about x <small>deg</small>", "camera_rotation_rad", 0, kDegrees},
    {"Camera turned about y <small>deg</small>", "camera_rotation_rad", 1, kDegrees},
    {"Camera turned about z <small>deg</small>", "camera_rotation_rad", 2, kDegrees}};

double device_number(const json& device, const DeviceNumber& number) {
  if (number.axis < 0) return number.unit * number_at(device, number.key);
  const json& vector = at(device, number.key);
  if (!vector.is_array() || vector.size() != 3) return std::nan("");
  const json& value = vector[static_cast<std::size_t>(number.axis)];
  return value.is_number() ? number.unit * value.get<double>() : std::nan("");
}

std::string device_rows(const json& device) {
  std::string out;
  for (const DeviceNumber& number : kDeviceNumbers) {
    out += fmt::format("<tr><th>{}</th><td>{}</td><td>{}</td></tr>\n", number.label,
                       number_text(device_number(at(device, "before"), number)),
                       number_text(device_number(at(device, "after"), number)));
  }
  return out;
}

}  // namespace

std::string sequences_table(const FinetuneContent& content) {
  const json& sequences = at(content.metrics, "sequences");
  if (sequences.size() < 2) return "";
  std::string out =
      "<h3>Sequence by sequence</h3><div class=\"scroll\"><table><thead><tr><th></th>";
  for (const Measure& measure : chosen_measures()) {
    out += fmt::format("<th>{} <small>{}</small></th>", measure.label, measure.unit);
  }
  out += "</tr></thead><tbody>\n";
  for (const json& sequence : sequences) out += sequence_row(sequence);
  return out + "</tbody></table></div>";
}

std::string device_table(const FinetuneContent& content) {
  const json& sequences = at(content.metrics, "sequences");
  // Sequences of one device share it.
  std::string out;
  std::vector<std::string> shown;
  for (const json& sequence : sequences) {
    const json& device = at(sequence, "device");
    const std::string fingerprint = text_at(device, "fingerprint");
    if (std::find(shown.begin(), shown.end(), fingerprint) != shown.end()) continue;
    shown.push_back(fingerprint);
    out += "<table><thead><tr><th>" + escape_html(fingerprint) +
           "</th><th>before</th><th>after</th></tr></thead><tbody>\n" + device_rows(device) +
           "</tbody></table>";
  }
  return out;
}

}  // namespace imslam::report

#include "slam/report/finetune_cells.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imslam::report {

using nlohmann::json;

namespace {

const json kNone = json::object();

bool is_loss(const Measure& measure) { return measure.unit[0] == '\0'; }

}  // namespace

const json& at(const json& object, const char* key) {
  if (!object.is_object()) return kNone;
  const auto found = object.find(key);
  return found == object.end() ? kNone : *found;
}

std::string number_text(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "–";
}

Change change_of(const Measure& measure, double before, double after) {
  if (!std::isfinite(before) || !std::isfinite(after)) return {"–", "same"};
  Change change;
  if (is_loss(measure)) {
    change.text = fmt::format("{:+.4f}", after - before);
  } else if (before > 0.0) {
    change.text = fmt::format("{:+.1f} %", 100.0 * (after - before) / before);
  }
  if (after < before) change.kind = "good";
  if (after > before) change.kind = "bad";
  return change;
}

}  // namespace imslam::report

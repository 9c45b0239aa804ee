#include "slam/report/json_text.hpp"

#include <cmath>
#include <limits>

#include "slam/base/error.hpp"

namespace imslam::report {
namespace {

constexpr int kMaxDepth = 32;

}  // namespace

nlohmann::json parse_json(const std::string& text, const std::string& name) {
  const auto shallow = [&](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > kMaxDepth) throw InputError(name + ": expected at most 32 nested levels");
    return true;
  };
  try {
    return nlohmann::json::parse(text, shallow);
  } catch (const nlohmann::json::exception& problem) {
    throw InputError(name + ": expected JSON; " + problem.what());
  }
}

double number_at(const nlohmann::json& object, const std::string& key) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  if (!object.is_object()) return nothing;
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return nothing;
  const double value = found->get<double>();
  return std::isfinite(value) ? value : nothing;
}

std::string text_at(const nlohmann::json& object, const std::string& key) {
  if (!object.is_object()) return "";
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace imslam::report

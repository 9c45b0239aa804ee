#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace imslam::report {

/// Parses `text`; throws InputError "name: ..." for broken JSON, numbers beyond double and nesting
/// deeper than 32 (which would exhaust the stack when it is written again).
nlohmann::json parse_json(const std::string& text, const std::string& name);

/// The number at `object[key]` if there is one that is finite, else NaN.
double number_at(const nlohmann::json& object, const std::string& key);

/// The text at `object[key]`, or "".
std::string text_at(const nlohmann::json& object, const std::string& key);

}  // namespace imslam::report

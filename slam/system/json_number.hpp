#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace imslam::system {

/// JSON has neither NaN nor infinity: what is not determined is null.
inline nlohmann::json number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

inline nlohmann::json number(const std::optional<double>& value) {
  return value ? number(*value) : nlohmann::json(nullptr);
}

}  // namespace imslam::system

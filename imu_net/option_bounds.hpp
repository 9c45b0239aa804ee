#pragma once

#include <string>

#include "slam/base/error.hpp"

namespace imslam::imu {

/// Throws InputError(kUsage) naming key, value and bound unless `holds`.
inline void check_option(bool holds, const std::string& key, double value, const char* bound) {
  if (holds) return;
  throw InputError("imu." + key + " = " + std::to_string(value) + ": must be " + bound,
                   ExitCode::kUsage);
}

}  // namespace imslam::imu

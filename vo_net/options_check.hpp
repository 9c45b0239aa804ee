#pragma once

#include <sstream>
#include <string>

#include "slam/base/error.hpp"

namespace imslam::vo {

/// Throws InputError(kUsage) naming key, value and bound unless `holds`.
template <typename Value>
void require(bool holds, const std::string& key, const Value& value, const std::string& bound) {
  if (holds) return;
  std::ostringstream message;
  message << key << ": expected " << bound << ", got " << value;
  throw InputError(message.str(), ExitCode::kUsage);
}

}  // namespace imslam::vo

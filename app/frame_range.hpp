#pragma once

#include <string>

#include "slam/system/run_sequence.hpp"

namespace imslam::app {

/// "A:B", "A:" or ":B" of --frames; B is not included. Throws InputError(kUsage).
void parse_frames(const std::string& text, system::RunRequest& request);

}  // namespace imslam::app

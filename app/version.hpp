#pragma once

#include <string>

namespace imslam::app {

/// "imslam 0.1.0 (git 1234abcd)": the hash is taken when the build is configured.
std::string version_text();
std::string git_hash();

}  // namespace imslam::app

#pragma once

#include <map>
#include <string>

namespace imslam::system {

/// Name and version of the libraries that decide the numbers, and the compiler's.
std::map<std::string, std::string> library_versions();

}  // namespace imslam::system

#pragma once

#include <string_view>

namespace imslam::report {

/// A file of template/ or of a third-party package, embedded at build time. Throws ContractError
/// for a name that slam/report/CMakeLists.txt does not list.
std::string_view asset(std::string_view name);

}  // namespace imslam::report

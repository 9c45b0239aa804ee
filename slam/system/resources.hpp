#pragma once

namespace imslam::system {

double peak_memory_mb();     ///< largest resident set of this process so far [MiB]
double present_memory_mb();  ///< resident set now [MiB]

}  // namespace imslam::system

#pragma once

#include <filesystem>
#include <vector>

#include "datasets/finding.hpp"

namespace imslam::datasets {

/// Goes through the text files of a recording line by line and lists what the readers would sort,
/// drop or refuse: malformed lines, stamps out of order, repeated, in the wrong unit, clock jumps,
/// values that are not finite. Works whether or not the recording as a whole can be opened.
void check_files(const std::filesystem::path& folder, Findings& findings);

/// Where a recording in EuRoC's or the plain layout keeps its samples, there or not.
std::vector<std::filesystem::path> imu_files(const std::filesystem::path& folder);

/// One IMU csv; one index of images (time_ns, file).
void check_imu_csv(const std::filesystem::path& file, Findings& findings);
void check_image_csv(const std::filesystem::path& file, Findings& findings);

}  // namespace imslam::datasets

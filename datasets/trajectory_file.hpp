#pragma once

#include <filesystem>
#include <string>

#include "slam/sensors/trajectory.hpp"

namespace imslam::datasets {

enum class TrajectoryFormat { kTum, kKitti, kEuroc };

/// Guesses from the first data line: 8 blank-separated numbers are TUM, 12 KITTI, comma-separated
/// EuRoC. Throws InputError naming file and line otherwise.
TrajectoryFormat detect_trajectory_format(const std::filesystem::path& file);

/// Reads exactly what stands in the file, in file order. `#` lines are comments, a BOM and trailing
/// blanks are accepted. Throws InputError "file:line: ..." on wrong columns, non-finite numbers or
/// a zero quaternion.
PosePath read_trajectory(const std::filesystem::path& file);

/// TUM: seconds, tx ty tz qx qy qz qw. KITTI: 3x4 row major. EuRoC: nanoseconds, p, q (w first).
/// Written atomically; numbers read back as the same doubles.
void write_trajectory(const std::filesystem::path& file,
                      const Trajectory& trajectory,
                      TrajectoryFormat format);

}  // namespace imslam::datasets

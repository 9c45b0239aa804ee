#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slam/report/pcd_reader.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::report {

/// What a run folder holds, as it was found. Empty texts and trajectories: the file is absent.
struct RunContent {
  std::string name;  ///< of the folder

  std::string metrics_json;   ///< metrics.json: see slam/system/run_recorder
  std::string series_json;    ///< series.json: columns over time, RPE samples
  std::string config_yaml;    ///< effective configuration
  std::string manifest_json;  ///< versions, seed, hashes

  Trajectory graph;  ///< trajectory.tum
  Trajectory vo;     ///< vo_only.tum
  Trajectory truth;  ///< truth.tum, already in the world frame of `graph`
  PointCloud map;    ///< map.pcd

  std::vector<std::string> notes;  ///< what is missing or unreadable, for the reader of the report
};

inline constexpr std::size_t kMaxMapPoints = 60000;

/// Reads what is there. A missing or damaged file becomes a note; only a folder that does not
/// exist throws InputError.
RunContent read_run(const std::filesystem::path& run_folder);

/// Lines "seconds tx ty tz qx qy qz qw"; '#' starts a comment. Lines with numbers that are not
/// finite, a zero quaternion or a stamp that does not increase are left out and counted in
/// `skipped`. Throws InputError "file:line: ..." for anything else.
Trajectory read_tum(const std::filesystem::path& file, std::size_t* skipped = nullptr);

}  // namespace imslam::report

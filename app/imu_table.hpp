#pragma once

#include <string>
#include <vector>

#include "slam/training/inertial_log_file.hpp"
#include "slam/training/open_integration.hpp"

namespace imslam::app {

/// One method over windows of one length.
struct ImuRow {
  std::string method;
  double window_s = 0.0;
  training::OpenScore score;
};

/// All methods on one log, or on several put together.
struct ImuTable {
  std::string title;
  std::vector<std::string> remarks;
  std::vector<ImuRow> rows;
};

/// The log in two lines: readings, where its velocities come from, gravity, jumps.
std::vector<std::string> describe(const training::InertialLogReading& reading);

std::string as_text(const ImuTable& table);
std::string as_csv(const std::vector<ImuTable>& tables);
std::string as_json(const std::vector<ImuTable>& tables);

}  // namespace imslam::app

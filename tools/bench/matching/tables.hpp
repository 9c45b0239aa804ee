#pragma once

#include <filesystem>
#include <vector>

#include "tools/bench/matching/summary.hpp"
#include "tools/bench/matching/warp_check.hpp"

namespace imslam::bench {

struct CheckedKind {
  vo::MatchKind kind;
  WarpCheck check;
};

// Markdown on standard output.

void print_checks(const DataSet& data, const std::vector<CheckedKind>& checks);

/// Of one data set: per kind the methods' own operating points, then all at KLT's coverage, then
/// how well the network is calibrated. A row per condition and severity, a column per method.
void print_tables(const std::vector<Summary>& summaries);

/// All numbers of a run. InputError(kOutput) if the file cannot be written.
void write_json(const std::filesystem::path& file, const std::vector<Summary>& summaries);

}  // namespace imslam::bench

#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "slam/base/process_group.hpp"
#include "slam/system/suite_file.hpp"
#include "slam/system/suite_table.hpp"

namespace imslam::system {

/// A row of ours in the making: what it is called, and what it makes of one sequence.
struct SuiteMethod {
  std::string name;
  /// May throw InputError: a dash, with the message as its note. Called in the process that the
  /// sequence belongs to, for all methods in order, one sequence after the other.
  std::function<SuiteCell(const SuiteSequence& sequence, const std::filesystem::path& data)>
      measure;
};

/// Applies all methods to all sequences, which are shared out among the processes by index. Rank 0
/// gets the rows, in the order of `methods` and the same for any number of ranks; the others get
/// none. A sequence that is not there is a dash with a note (kData).
std::vector<SuiteRow> run_suite(const Suite& suite,
                                const std::filesystem::path& root,
                                const std::vector<SuiteMethod>& methods,
                                ProcessGroup& group);

/// The suite's figures out of a block of metrics.json ("vo", "graph", "online", ...); a note where
/// there are none.
SuiteCell suite_cell(const nlohmann::json& metrics,
                     const std::string& block,
                     const std::vector<SuiteFigure>& figures);

}  // namespace imslam::system

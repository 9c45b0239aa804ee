#pragma once

#include <string>
#include <vector>

#include "slam/base/error.hpp"
#include "slam/system/suite_file.hpp"

namespace imslam::system {

/// What one method has reached on one sequence.
struct SuiteCell {
  SuiteValues figures;            ///< as suite_figures(); empty: a dash
  std::string note;               ///< why there is a dash, or what to know of the figures
  ExitCode code = ExitCode::kOk;  ///< of a run that ended so
};

/// What one method of ours has reached.
struct SuiteRow {
  std::string name;
  std::vector<SuiteCell> cells;  ///< by sequence
};

/// The figures of a suite, the published rows first, then ours: what is printed.
struct SuiteTable {
  struct Row {
    std::string name;
    std::string mark;  ///< of its source; may be empty
    bool ours = false;
    std::vector<SuiteValues> values;  ///< [figure][sequence]
    SuiteValues averages;             ///< [figure]
    std::size_t averaged = 0;         ///< over how many sequences; 0: as published
  };

  std::string title;
  std::vector<SuiteFigure> figures;
  std::vector<std::string> sequences;
  std::vector<Row> rows;
  std::vector<std::string> notes;  ///< sources, then why there are dashes

  /// Our row's average does not count all sequences: not comparable with the published ones.
  bool is_partial(const Row& row) const {
    return row.averaged > 0 && row.averaged < sequences.size();
  }
};

/// The average of our rows is the mean over the sequences that have the figures, as papers do it
/// (the KITTI devkit would weigh sequences by their number of segments).
SuiteTable make_suite_table(const Suite& suite, const std::vector<SuiteRow>& ours);

/// The code of the first cell, sequence by sequence, that did not end well.
ExitCode exit_code_of(const std::vector<SuiteRow>& ours);

std::string as_text(const SuiteTable& table);   ///< aligned, with notes, for a terminal
std::string as_csv(const SuiteTable& table);    ///< a line per row and figure
std::string as_latex(const SuiteTable& table);  ///< a booktabs tabular, to be pasted

}  // namespace imslam::system

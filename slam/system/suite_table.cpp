#include "slam/system/suite_table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace imslam::system {
namespace {

SuiteTable::Row our_row(const Suite& suite, const SuiteRow& row) {
  SuiteTable::Row result;
  result.name = row.name;
  result.ours = true;
  expects(row.cells.size() == suite.sequences.size(), "make_suite_table: a cell per sequence");
  for (std::size_t f = 0; f < suite.figures().size(); ++f) {
    SuiteValues values;
    double sum = 0.0;
    std::size_t count = 0;
    for (const SuiteCell& cell : row.cells) {
      values.push_back(f < cell.figures.size() ? cell.figures[f] : std::nullopt);
      if (!values.back()) continue;
      sum += *values.back();
      ++count;
    }
    result.values.push_back(std::move(values));
    result.averages.push_back(count == 0 ? std::nullopt
                                         : std::optional(sum / static_cast<double>(count)));
    result.averaged = std::max(result.averaged, count);
  }
  return result;
}

/// Messages may have several lines; tables and LaTeX comments may not.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

/// Why there are dashes: once per sequence where all rows say the same.
void add_notes(const std::vector<SuiteRow>& ours, SuiteTable& table) {
  if (ours.empty()) return;
  for (std::size_t s = 0; s < table.sequences.size(); ++s) {
    const std::string& first = ours.front().cells[s].note;
    const bool same = std::all_of(ours.begin(), ours.end(),
                                  [&](const SuiteRow& row) { return row.cells[s].note == first; });
    for (const SuiteRow& row : ours) {
      const std::string& note = row.cells[s].note;
      if (note.empty()) continue;
      table.notes.push_back(same ? fmt::format("{}: {}", table.sequences[s], note)
                                 : fmt::format("{}, {}: {}", table.sequences[s], row.name, note));
      if (same) break;
    }
  }
}

}  // namespace

SuiteTable make_suite_table(const Suite& suite, const std::vector<SuiteRow>& ours) {
  SuiteTable table;
  table.title = one_line(suite.name);
  table.figures = suite.figures();
  for (const SuiteSequence& sequence : suite.sequences) table.sequences.push_back(sequence.name);
  for (const PublishedRow& row : suite.published) {
    table.rows.push_back({row.name, row.source, false, row.values, row.averages, 0});
  }
  for (const SuiteRow& row : ours) table.rows.push_back(our_row(suite, row));
  for (const auto& [mark, meaning] : suite.sources) {
    table.notes.push_back(fmt::format("[{}] {}", mark, meaning));
  }
  const auto partial = [&](const auto& row) { return table.is_partial(row); };
  if (std::any_of(table.rows.begin(), table.rows.end(), partial)) {
    table.notes.emplace_back(
        "* mean of the sequences that have a figure, not of all: do not compare with the others");
  }
  add_notes(ours, table);
  for (std::string& note : table.notes) note = one_line(note);
  return table;
}

ExitCode exit_code_of(const std::vector<SuiteRow>& ours) {
  const std::size_t sequences = ours.empty() ? 0 : ours.front().cells.size();
  for (std::size_t s = 0; s < sequences; ++s) {
    for (const SuiteRow& row : ours) {
      if (row.cells[s].code != ExitCode::kOk) return row.cells[s].code;
    }
  }
  return ExitCode::kOk;
}

}  // namespace imslam::system

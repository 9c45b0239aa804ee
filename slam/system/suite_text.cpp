// The three faces of a suite's table.
#include <fmt/format.h>

#include <algorithm>

#include "slam/base/text.hpp"
#include "slam/system/suite_table.hpp"

namespace imslam::system {
namespace {

std::string cell(const std::optional<double>& value, int digits, const char* dash) {
  return value ? fmt::format("{:.{}f}", *value, digits) : dash;
}

std::string label(const SuiteTable::Row& row) {
  return row.mark.empty() ? row.name : fmt::format("{} [{}]", row.name, row.mark);
}

/// Where the published rows end and ours begin.
bool first_of_ours(const SuiteTable& table, std::size_t r) {
  return r > 0 && table.rows[r].ours && !table.rows[r - 1].ours;
}

std::size_t value_width(const SuiteTable& table) {
  std::size_t width = 8;
  for (const std::string& name : table.sequences) width = std::max(width, name.size());
  return width + 2;
}

}  // namespace

std::string as_text(const SuiteTable& table) {
  const std::size_t width = value_width(table);
  std::size_t names = 0;
  for (const SuiteFigure& figure : table.figures) names = std::max(names, figure.title.size());
  for (const auto& row : table.rows) names = std::max(names, label(row).size());

  std::string text = table.title + "\n";
  for (std::size_t f = 0; f < table.figures.size(); ++f) {
    const SuiteFigure& figure = table.figures[f];
    text += fmt::format("\n{:<{}}", figure.title, names);
    for (const std::string& name : table.sequences) text += fmt::format("{:>{}}", name, width);
    text += fmt::format("{:>{}}\n", "average", width);
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const auto& row = table.rows[r];
      if (first_of_ours(table, r)) {
        text += std::string(names + width * (table.sequences.size() + 1), '-') + "\n";
      }
      text += fmt::format("{:<{}}", label(row), names);
      for (const auto& value : row.values[f]) {
        text += fmt::format("{:>{}}", cell(value, figure.digits, "-"), width);
      }
      text += fmt::format("{:>{}}", cell(row.averages[f], figure.digits, "-"), width);
      if (table.is_partial(row)) text += " *";
      text += "\n";
    }
  }
  if (!table.notes.empty()) text += "\n";
  for (const std::string& note : table.notes) text += note + "\n";
  return text;
}

std::string as_csv(const SuiteTable& table) {
  std::string text = "row,source,figure";
  for (const std::string& name : table.sequences) text += "," + csv_field(name);
  text += ",average,averaged_over\n";
  for (const SuiteFigure& figure : table.figures) {
    const auto f = static_cast<std::size_t>(&figure - table.figures.data());
    for (const auto& row : table.rows) {
      text += fmt::format("{},{},{}", csv_field(row.name), csv_field(row.mark), figure.key);
      for (const auto& value : row.values[f]) text += value ? fmt::format(",{}", *value) : ",";
      text += row.averages[f] ? fmt::format(",{}", *row.averages[f]) : ",";
      text += row.averaged > 0 ? fmt::format(",{}\n", row.averaged) : ",\n";
    }
  }
  return text;
}

std::string as_latex(const SuiteTable& table) {
  const std::size_t columns = table.sequences.size() + 2;
  std::string text = fmt::format("% {}; booktabs\n\\begin{{tabular}}{{l{}}}\n\\toprule\n",
                                 table.title, std::string(columns - 1, 'r'));
  for (const std::string& name : table.sequences) text += " & " + latex_text(name);
  text += " & avg. \\\\\n";
  for (std::size_t f = 0; f < table.figures.size(); ++f) {
    const SuiteFigure& figure = table.figures[f];
    text += fmt::format("\\midrule\n\\multicolumn{{{}}}{{l}}{{{}}} \\\\\n", columns, figure.latex);
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const auto& row = table.rows[r];
      if (first_of_ours(table, r)) text += fmt::format("\\cmidrule{{1-{}}}\n", columns);
      text += latex_text(label(row));
      for (const auto& value : row.values[f]) text += " & " + cell(value, figure.digits, "--");
      text += " & " + cell(row.averages[f], figure.digits, "--");
      text += table.is_partial(row) ? "$^*$ \\\\\n" : " \\\\\n";
    }
  }
  text += "\\bottomrule\n\\end{tabular}\n";
  for (const std::string& note : table.notes) text += "% " + note + "\n";
  return text;
}

}  // namespace imslam::system

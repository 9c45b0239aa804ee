#include "tools/bench/matching/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace imslam::bench {
namespace {

using vo::MatchKind;
using Rows = std::vector<const Summary*>;
using Cell = std::function<std::string(const Summary&)>;

std::string number(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

std::string percent(double share) { return number(100.0 * share, "{:.1f}"); }

std::string trial_name(const Trial& trial) {
  if (trial.severity == 0) return "clean";
  const double value = trial.condition.values.at(static_cast<std::size_t>(trial.severity - 1));
  return fmt::format("{} {} ({:g} {})", trial.condition.name, trial.severity, value,
                     trial.condition.unit);
}

std::vector<std::string> methods_of(const Rows& rows) {
  std::vector<std::string> methods;
  for (const Summary* row : rows) {
    if (std::find(methods.begin(), methods.end(), row->method) == methods.end()) {
      methods.push_back(row->method);
    }
  }
  return methods;
}

/// `rows` hold every trial once per method, in the methods' order.
void print_table(const Rows& rows, const Cell& first, const char* first_head, const Cell& cell) {
  const std::vector<std::string> methods = methods_of(rows);
  fmt::print("| | {} |", first_head);
  for (const std::string& method : methods) fmt::print(" {} |", method);
  fmt::print("\n|---|---|");
  for (std::size_t i = 0; i < methods.size(); ++i) fmt::print("---|");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i % methods.size() == 0) {
      fmt::print("\n| {} | {} |", trial_name(rows[i]->trial), first(*rows[i]));
    }
    fmt::print(" {} |", cell(*rows[i]));
  }
  fmt::print("\n\n");
}

Rows rows_where(const std::vector<Summary>& summaries,
                const std::function<bool(const Summary&)>& wanted) {
  Rows rows;
  for (const Summary& summary : summaries) {
    if (wanted(summary)) rows.push_back(&summary);
  }
  return rows;
}

std::string natural_cell(const Summary& s) {
  return fmt::format("{} / {} / {} / {}", number(s.natural.median, "{:.2f}"),
                     number(s.natural.mean, "{:.2f}"), percent(s.natural.gross),
                     percent(s.natural.coverage));
}

/// A star: the method had fewer answers than KLT accepts.
std::string equal_cell(const Summary& s) {
  return fmt::format("{} / {}{}", number(s.equal->median, "{:.2f}"), percent(s.equal->gross),
                     s.equal->points < s.klt_points ? " *" : "");
}

std::string calibration_cell(const Summary& s) {
  return fmt::format("{} / {} / {}", number(s.calibration->normalised_median, "{:.2f}"),
                     percent(s.calibration->stated), percent(s.calibration->right));
}

void print_kind(const std::vector<Summary>& summaries, MatchKind kind) {
  const Rows rows = rows_where(summaries, [&](const Summary& s) { return s.kind == kind; });
  if (rows.empty()) return;
  const std::string title = fmt::format("{}, {}", rows[0]->data, kind_name(kind));
  const Cell queries = [](const Summary& s) { return fmt::format("{}", s.queries); };
  fmt::print("### {}: median px / mean px / > {:g} px % / coverage %\n\n", title, kGrossError);
  print_table(rows, queries, "points", natural_cell);
  const Rows equal = rows_where(
      summaries, [&](const Summary& s) { return s.kind == kind && s.equal.has_value(); });
  if (!equal.empty()) {
    fmt::print(
        "### {}, best points up to KLT's coverage (*: all, they are fewer): median px / "
        "> {:g} px %\n\n",
        title, kGrossError);
    print_table(
        equal,
        [](const Summary& s) {
          return percent(static_cast<double>(s.klt_points) / static_cast<double>(s.queries));
        },
        "coverage %", equal_cell);
  }
  const Rows stated = rows_where(
      summaries, [&](const Summary& s) { return s.kind == kind && s.calibration.has_value(); });
  if (stated.empty()) return;
  fmt::print(
      "### {}, calibration: median normalised error (ideal {}) / mean stated confidence % / "
      "errors < {:g} px %\n\n",
      title, kind == MatchKind::kFlow ? "1.33" : "0.77", kConfidentError);
  print_table(stated, queries, "points", calibration_cell);
}

}  // namespace

void print_checks(const DataSet& data, const std::vector<CheckedKind>& checks) {
  for (const auto& [kind, check] : checks) {
    fmt::print("| {} | {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {} |\n", data.name,
               kind_name(kind), check.scenes, check.points, check.truth, check.one_pixel,
               check.no_motion, check.holds() ? "holds" : "DOUBTFUL");
  }
}

void print_tables(const std::vector<Summary>& summaries) {
  print_kind(summaries, MatchKind::kFlow);
  print_kind(summaries, MatchKind::kStereo);
}

}  // namespace imslam::bench

#include "slam/system/suite_bench.hpp"

#include <nlohmann/json.hpp>

#include "slam/base/log.hpp"
#include "slam/base/packed_strings.hpp"

namespace imslam::system {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

/// JSON keeps every double: it writes the shortest text that reads back as the same.
std::string packed(const SuiteCell& cell) {
  Json figures = Json::array();
  for (const auto& value : cell.figures) figures.push_back(value ? Json(*value) : Json());
  const Json json = {
      {"figures", figures}, {"note", cell.note}, {"code", static_cast<int>(cell.code)}};
  // Paths in messages may hold bytes that are not UTF-8.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

SuiteCell unpacked(const std::string& text) {
  const Json json = Json::parse(text);
  SuiteCell cell;
  for (const Json& value : json.at("figures")) {
    cell.figures.push_back(value.is_null() ? std::nullopt : std::optional(value.get<double>()));
  }
  cell.note = json.at("note").get<std::string>();
  cell.code = static_cast<ExitCode>(json.at("code").get<int>());
  return cell;
}

SuiteCell measure(const SuiteMethod& method,
                  const SuiteSequence& sequence,
                  const std::optional<fs::path>& data) {
  if (!data) return {{}, sequence.paths.front().string() + " is not there", ExitCode::kData};
  try {
    return method.measure(sequence, *data);
  } catch (const InputError& error) {
    if (error.code() == ExitCode::kOutput || error.code() == ExitCode::kUsage) throw;
    return {{}, error.what(), error.code()};
  }
}

}  // namespace

std::vector<SuiteRow> run_suite(const Suite& suite,
                                const fs::path& root,
                                const std::vector<SuiteMethod>& methods,
                                ProcessGroup& group) {
  const auto sequence_cells = [&](std::size_t s) {
    const SuiteSequence& sequence = suite.sequences[s];
    const auto data = find_sequence(root, sequence);
    std::vector<std::string> cells;
    for (const SuiteMethod& method : methods) {
      const SuiteCell cell = measure(method, sequence, data);
      if (!cell.note.empty()) log::warn("{}, {}: {}", sequence.name, method.name, cell.note);
      cells.push_back(packed(cell));
    }
    return pack_strings(cells);
  };
  const auto columns = gather_items(group, suite.sequences.size(), sequence_cells);
  std::vector<SuiteRow> rows;
  if (group.rank() != 0) return rows;
  for (const SuiteMethod& method : methods) rows.push_back({method.name, {}});
  for (const std::string& column : columns) {
    const auto cells = unpack_strings(column);
    for (std::size_t r = 0; r < rows.size(); ++r) rows[r].cells.push_back(unpacked(cells.at(r)));
  }
  return rows;
}

SuiteCell suite_cell(const Json& metrics,
                     const std::string& block,
                     const std::vector<SuiteFigure>& figures) {
  SuiteCell cell;
  if (!metrics.contains(block)) {
    return {{}, "no ground truth that fits, no figures", ExitCode::kEvaluation};
  }
  for (const SuiteFigure& figure : figures) {
    const Json& value = metrics.at(block).at(figure.key);
    if (value.is_number()) {
      cell.figures.emplace_back(value.get<double>());
      continue;
    }
    cell.figures.emplace_back(std::nullopt);
    cell.code = ExitCode::kEvaluation;
    cell.note = figure.key == "ate_se3_rmse_m" ? "the path is too short or straight to be aligned"
                                               : "the path is shorter than 100 m";
  }
  return cell;
}

}  // namespace imslam::system

#include "slam/adaptation/learning_log.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "slam/adaptation/epoch_scores.hpp"
#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"

namespace imslam::adaptation {
namespace {

/// A look at a graph that cannot teach has no loss: see score_epoch().
constexpr double kNoLoss = 1e299;

double number(std::string_view cell) {
  const double value = parse_double(cell).value_or(std::numeric_limits<double>::quiet_NaN());
  return std::abs(value) < kNoLoss ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

LearningLog read_learning_log(const std::filesystem::path& file, int steps_per_epoch) {
  const std::string text = read_file(file);
  const auto lines = split(text, '\n');
  const auto columns = split(lines.front(), ',');
  const std::string known = EpochScores::columns();
  LearningLog log;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (trim(lines[i]).empty()) continue;
    const auto cells = split(lines[i], ',');
    if (cells.size() != columns.size() || !parse_int64(cells[0])) {
      throw InputError(fmt::format("{}:{}: expected {} cells, the first one a step", file.string(),
                                   i + 1, columns.size()));
    }
    log.epoch.push_back(number(cells[0]) / steps_per_epoch);
    log.curves["held_out_loss"].push_back(number(cells[2]));
    for (const std::string_view name : split(known, ',')) {
      for (std::size_t c = 3; c < columns.size(); ++c) {
        if (columns[c] == name) log.curves[std::string(name)].push_back(number(cells[c]));
      }
    }
  }
  return log;
}

}  // namespace imslam::adaptation

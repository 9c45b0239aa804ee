#include "slam/plugins/routing/read_instance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/text.hpp"

namespace imslam::routing {
namespace {

constexpr std::size_t kLargestFile = std::size_t{1} << 30U;

[[noreturn]] void fail(const std::string& name, std::size_t line, const std::string& what) {
  throw InputError(fmt::format("{}:{}: {}", name, line, what));
}

struct Row {
  std::size_t line = 0;
  std::vector<double> numbers;
};

std::vector<std::string_view> words_of(std::string_view line) {
  for (const char separator : {',', ';'}) {
    if (line.find(separator) != std::string_view::npos) return split(line, separator);
  }
  return split_blanks(line);
}

/// Empty if a word is not a number.
std::optional<std::vector<double>> numbers_of_words(const std::vector<std::string_view>& words) {
  std::vector<double> numbers;
  for (const std::string_view word : words) {
    const auto number = parse_double(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::vector<Row> read_rows(const std::string& name, const std::string& text) {
  std::vector<Row> rows;
  bool named = false;
  std::size_t number = 0;
  for (std::string_view line : split(text, '\n')) {
    ++number;
    line = trim(line);
    if (line.empty() || line.front() == '#') continue;
    const auto numbers = numbers_of_words(words_of(line));
    if (!numbers && rows.empty() && !named) {
      named = true;  // the names of the columns
      continue;
    }
    if (!numbers) fail(name, number, "expected numbers, separated by commas, semicolons or blanks");
    for (const double value : *numbers) {
      if (!std::isfinite(value))
        fail(name, number, "a number is not finite; give or drop the city");
    }
    rows.push_back({number, *numbers});
    if (rows.size() > kMostCities) {
      fail(name, number, fmt::format("more than {} cities", kMostCities));
    }
  }
  if (rows.size() < 2) {
    fail(name, number, fmt::format("{} cities: expected 2 or more, a line each", rows.size()));
  }
  return rows;
}

Instance distances_of(const std::string& name, const std::vector<Row>& rows) {
  Instance instance;
  instance.metric = Metric::kMatrix;
  for (const Row& row : rows) {
    if (row.numbers.size() != rows.size()) {
      fail(name, row.line,
           fmt::format("a table of distances between {} cities: expected {} numbers, found {}",
                       rows.size(), rows.size(), row.numbers.size()));
    }
    for (const double distance : row.numbers) {
      if (distance < 0.0) fail(name, row.line, "a distance is negative");
    }
    instance.matrix.insert(instance.matrix.end(), row.numbers.begin(), row.numbers.end());
  }
  return instance;
}

/// Numbers that swallow all others: a "no road" of 1e30 leaves nothing to compare tours by.
void check_magnitudes(const std::string& name, const Instance& instance) {
  constexpr double kLargestCoordinate = 1e15;
  constexpr double kLargestRatio = 1e12;
  for (const Point& point : instance.points) {
    if (std::abs(point.x) > kLargestCoordinate || std::abs(point.y) > kLargestCoordinate) {
      throw InputError(fmt::format("{}: a coordinate of {:g}; at most {:g} can be computed with",
                                   name, std::max(std::abs(point.x), std::abs(point.y)),
                                   kLargestCoordinate));
    }
  }
  std::vector<double> distances;
  for (const double distance : instance.matrix) {
    if (distance > 0.0) distances.push_back(distance);
  }
  if (distances.empty()) return;
  // Most roads may be missing: what is usual is what the shorter ones are.
  const auto usual = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 10);
  std::nth_element(distances.begin(), usual, distances.end());
  const double longest = *std::max_element(usual, distances.end());
  if (longest > std::min(kLargestRatio * *usual, 1e30)) {
    throw InputError(
        fmt::format("{}: a distance of {:g} among usual ones of {:g}; for a road that "
                    "is not there write about a thousand times a usual distance",
                    name, longest, *usual));
  }
}

}  // namespace

Instance parse_table(const std::string& name, const std::string& text) {
  const std::vector<Row> rows = read_rows(name, text);
  if (rows.front().numbers.size() != 2) return distances_of(name, rows);
  Instance instance;
  for (const Row& row : rows) {
    if (row.numbers.size() != 2) {
      fail(
          name, row.line,
          fmt::format("expected x,y as in the lines before, found {} numbers", row.numbers.size()));
    }
    instance.points.push_back({row.numbers[0], row.numbers[1]});
  }
  return instance;
}

Instance parse_instance(const std::string& name, const std::string& text, int depot) {
  const bool tsplib = text.find("DIMENSION") != std::string::npos;
  Instance instance = tsplib ? parse_tsplib(name, text) : parse_table(name, text);
  check_magnitudes(name, instance);
  if (instance.name.empty()) instance.name = std::filesystem::path(name).stem().string();
  if (depot < 0 || depot >= instance.city_count()) {
    throw InputError(fmt::format("{}: there is no city {} to be the depot; give --depot 0 to {}",
                                 name, depot, instance.city_count() - 1));
  }
  instance.depot = depot;
  return instance;
}

Instance read_instance(const std::filesystem::path& file, int depot) {
  return parse_instance(file.string(), read_file(file, kLargestFile), depot);
}

}  // namespace imslam::routing

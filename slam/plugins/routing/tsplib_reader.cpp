#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "slam/base/error.hpp"
#include "slam/base/text.hpp"
#include "slam/plugins/routing/read_instance.hpp"

namespace imslam::routing {
namespace {

/// One file of TSPLIB 95, line by line.
class TsplibReader {
 public:
  TsplibReader(const std::string& name, const std::string& text)
      : name_(name), lines_(split(text, '\n')) {}

  Instance read() {
    Instance instance;
    while (line_ < lines_.size()) {
      const std::string_view line = trim(lines_[line_++]);
      const std::string_view key = trim(line.substr(0, line.find(':')));
      if (key == "EOF") break;
      if (key == "NODE_COORD_SECTION") {
        read_points(instance);
      } else if (key == "EDGE_WEIGHT_SECTION") {
        read_weights(instance);
      } else if (key == "DISPLAY_DATA_SECTION") {
        line_ += static_cast<std::size_t>(dimension());
      } else if (line.find(':') != std::string_view::npos) {
        note(std::string(key), std::string(trim(line.substr(line.find(':') + 1))));
      } else if (!line.empty()) {
        fail(fmt::format("expected a line KEY : VALUE or a section, found '{}'",
                         line.substr(0, 40)));
      }
    }
    return finished(std::move(instance));
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", name_, std::min(line_, lines_.size()), what));
  }

  void note(const std::string& key, const std::string& value) {
    values_[key] = value;
    const bool type = key == "TYPE";
    if (type && value != "TSP" && value != "ATSP") {
      fail("TYPE: expected TSP or ATSP, found " + value);
    }
    if (key == "EDGE_WEIGHT_TYPE") static_cast<void>(metric());
    if (key == "DIMENSION") static_cast<void>(dimension());
  }

  int dimension() const {
    const auto found = values_.find("DIMENSION");
    if (found == values_.end()) fail("DIMENSION is missing before the section");
    const auto number = parse_int64(found->second);
    if (!number || *number < 2 || *number > kMostCities) {
      fail(fmt::format("DIMENSION: expected 2 to {}, found {}", kMostCities, found->second));
    }
    return static_cast<int>(*number);
  }

  Metric metric() const {
    static const std::map<std::string, Metric> known = {{"EUC_2D", Metric::kEuclideanRounded},
                                                        {"CEIL_2D", Metric::kEuclideanCeiled},
                                                        {"GEO", Metric::kGeographic},
                                                        {"ATT", Metric::kPseudoEuclidean},
                                                        {"EXPLICIT", Metric::kMatrix}};
    const auto value = values_.find("EDGE_WEIGHT_TYPE");
    if (value == values_.end()) fail("EDGE_WEIGHT_TYPE is missing");
    const auto found = known.find(value->second);
    if (found == known.end()) {
      fail("EDGE_WEIGHT_TYPE: expected EUC_2D, CEIL_2D, GEO, ATT or EXPLICIT, found " +
           value->second);
    }
    return found->second;
  }

  void read_points(Instance& instance) {
    const int n = dimension();
    std::vector<char> seen(static_cast<std::size_t>(n), 0);
    instance.points.resize(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) {
      if (line_ >= lines_.size()) fail(fmt::format("ends after {} of {} cities", i, n));
      const auto words = split_blanks(lines_[line_++]);
      const auto number_of = [&](std::size_t word) {
        const auto value = word < words.size() ? parse_double(words[word]) : std::nullopt;
        return value.value_or(std::nan(""));
      };
      const double number = number_of(0);
      const Point point{number_of(1), number_of(2)};
      if (words.size() != 3 || !std::isfinite(point.x) || !std::isfinite(point.y) ||
          number != std::floor(number)) {
        fail("expected a city's number, x and y, both finite");
      }
      const int city = number >= 1.0 && number <= n ? static_cast<int>(number) - 1 : -1;
      if (city < 0 || seen[static_cast<std::size_t>(city)] != 0) {
        fail(fmt::format("city {}: expected each of 1 to {} once", words[0], n));
      }
      seen[static_cast<std::size_t>(city)] = 1;
      instance.points[static_cast<std::size_t>(city)] = point;
    }
  }

  /// All numbers up to the end of the section: their lines need not be the rows.
  double next_weight() {
    while (word_ >= words_.size()) {
      if (line_ >= lines_.size()) fail("EDGE_WEIGHT_SECTION: ends before all distances");
      words_ = split_blanks(lines_[line_++]);
      word_ = 0;
    }
    const auto number = parse_double(words_[word_++]);
    if (!number || !std::isfinite(*number) || *number < 0.0) {
      fail("EDGE_WEIGHT_SECTION: expected finite distances that are not negative");
    }
    return *number;
  }

  void read_weights(Instance& instance) {
    const int n = dimension();
    const std::string format = values_["EDGE_WEIGHT_FORMAT"];
    const bool full = format == "FULL_MATRIX";
    const bool upper = format == "UPPER_ROW" || format == "UPPER_DIAG_ROW";
    const bool lower = format == "LOWER_ROW" || format == "LOWER_DIAG_ROW";
    const bool diagonal = full || format.find("DIAG") != std::string::npos;
    if (!full && !upper && !lower) {
      fail(
          "EDGE_WEIGHT_FORMAT: expected FULL_MATRIX, UPPER_ROW, LOWER_ROW, UPPER_DIAG_ROW or "
          "LOWER_DIAG_ROW, found '" +
          format + "'");
    }
    const auto at = [n](int i, int j) {
      return static_cast<std::size_t>(i) * static_cast<std::size_t>(n) +
             static_cast<std::size_t>(j);
    };
    instance.matrix.assign(at(n - 1, n - 1) + 1, 0.0);
    for (int i = 0; i < n; ++i) {
      const int first = full || lower ? 0 : (diagonal ? i : i + 1);
      const int last = full || upper ? n - 1 : (diagonal ? i : i - 1);
      for (int j = first; j <= last; ++j) {
        const double weight = next_weight();
        if (i == j) continue;
        instance.matrix[at(i, j)] = weight;
        if (!full) instance.matrix[at(j, i)] = weight;
      }
    }
    if (word_ < words_.size()) fail("EDGE_WEIGHT_SECTION: more distances than DIMENSION says");
  }

  Instance finished(Instance instance) const {
    instance.metric = metric();
    const auto name = values_.find("NAME");
    if (name != values_.end()) instance.name = name->second;
    const bool table = instance.metric == Metric::kMatrix;
    if (table) instance.points.clear();
    if (table ? instance.matrix.empty() : instance.points.empty()) {
      fail(table ? "EDGE_WEIGHT_SECTION is missing" : "NODE_COORD_SECTION is missing");
    }
    return instance;
  }

  std::string name_;
  std::vector<std::string_view> lines_;
  std::size_t line_ = 0;
  std::map<std::string, std::string> values_;
  std::vector<std::string_view> words_;
  std::size_t word_ = 0;
};

}  // namespace

Instance parse_tsplib(const std::string& name, const std::string& text) {
  return TsplibReader(name, text).read();
}

}  // namespace imslam::routing

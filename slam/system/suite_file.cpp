#include "slam/system/suite_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "slam/base/error.hpp"
#include "slam/base/text.hpp"
#include "slam/base/yaml_reader.hpp"
#include "slam/system/run_folder.hpp"

namespace imslam::system {
namespace fs = std::filesystem;
namespace {

std::vector<SuiteSequence> read_sequences(const YamlEntry& root) {
  std::vector<SuiteSequence> sequences;
  std::set<std::string> names;
  for (const YamlEntry& entry : root.at("sequences").items()) {
    entry.only({"name", "path"});
    SuiteSequence sequence;
    sequence.name = entry.at("name").text();
    if (safe_name(sequence.name) != sequence.name || sequence.name.front() == '.') {
      entry.at("name").fail("letters, digits, '-', '_' and '.', it names a folder");
    }
    if (!names.insert(sequence.name).second) {
      entry.at("name").fail(fmt::format("another name, '{}' is taken", sequence.name));
    }
    const YamlEntry path = entry.at("path");
    if (path.is_list()) {
      for (const YamlEntry& each : path.items()) sequence.paths.emplace_back(each.text());
    } else {
      sequence.paths.emplace_back(path.text());
    }
    if (sequence.paths.empty()) path.fail("a folder, or several to choose from");
    sequences.push_back(std::move(sequence));
  }
  if (sequences.empty()) root.at("sequences").fail("at least one sequence");
  return sequences;
}

std::vector<std::pair<std::string, std::string>> read_sources(const YamlEntry& root) {
  std::vector<std::pair<std::string, std::string>> sources;
  const auto list = root.find("sources");
  if (!list) return sources;
  list->only(list->keys());  // nothing twice
  for (const std::string& mark : list->keys()) sources.emplace_back(mark, list->at(mark).text());
  return sources;
}

/// One value per sequence; all empty where the row does not have the figure.
SuiteValues read_values(const YamlEntry& row, const std::string& figure, std::size_t count) {
  SuiteValues values(count);
  const auto list = row.find(figure);
  if (!list) return values;
  const auto items = list->items();
  if (items.size() != count) {
    list->fail(fmt::format("one number (or -) per sequence, {}, got {}", count, items.size()));
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (items[i].text() != "-") values[i] = items[i].number();
  }
  return values;
}

std::optional<double> mean_of_all(const SuiteValues& values) {
  double sum = 0.0;
  for (const auto& value : values) {
    if (!value) return std::nullopt;
    sum += *value;
  }
  return sum / static_cast<double>(values.size());
}

void read_source(const YamlEntry& entry, const Suite& suite, PublishedRow& row) {
  const auto mark = entry.find("source");
  if (!mark) return;
  row.source = mark->text();
  const auto known = [&](const auto& source) { return source.first == row.source; };
  if (std::none_of(suite.sources.begin(), suite.sources.end(), known)) {
    mark->fail(fmt::format("a mark that `sources` explains, '{}' is not there", row.source));
  }
}

PublishedRow read_row(const YamlEntry& entry, const Suite& suite) {
  std::vector<std::string> names;
  for (const SuiteFigure& figure : suite.figures()) names.push_back(figure.name);
  std::vector<std::string> keys = {"name", "source", "average"};
  keys.insert(keys.end(), names.begin(), names.end());
  entry.only(keys);

  PublishedRow row;
  row.name = entry.at("name").text();
  read_source(entry, suite, row);
  const auto averages = entry.find("average");
  if (averages) averages->only(names);
  bool empty = true;
  for (const std::string& name : names) {
    row.values.push_back(read_values(entry, name, suite.sequences.size()));
    const auto given = averages ? averages->find(name) : std::nullopt;
    row.averages.push_back(given ? std::optional(given->number()) : mean_of_all(row.values.back()));
    empty = empty && !entry.find(name) && !given;
  }
  if (empty) entry.fail(fmt::format("a value: {} or average", fmt::join(names, ", ")));
  return row;
}

std::string optional_text(const YamlEntry& root, const std::string& key) {
  const auto value = root.find(key);
  return value ? value->text() : "";
}

}  // namespace

const std::vector<SuiteFigure>& suite_figures(const std::string& metric) {
  static const std::vector<SuiteFigure> kitti = {
      {"t_rel_percent", "t_rel", "t_rel [%]", "$t_\\mathrm{rel}$ [\\%]", 3},
      {"r_rel_deg_per_100m", "r_rel", "r_rel [deg/100 m]", "$r_\\mathrm{rel}$ [$^\\circ$/100\\,m]",
       3}};
  static const std::vector<SuiteFigure> euroc = {
      {"ate_se3_rmse_m", "ate", "ATE, SE(3) aligned [m]", "ATE [m]", 3}};
  if (metric == "kitti") return kitti;
  if (metric == "euroc") return euroc;
  throw InputError(fmt::format("metric must be kitti or euroc, got '{}'", metric),
                   ExitCode::kUsage);
}

Suite read_suite(const fs::path& file) {
  const YamlEntry root = read_yaml(file);
  root.only({"name", "metric", "root", "config", "sequences", "sources", "published"});
  Suite suite;
  suite.name = root.at("name").text();
  suite.metric = root.at("metric").text();
  if (suite.metric != "kitti" && suite.metric != "euroc") {
    root.at("metric").fail(fmt::format("kitti or euroc, got '{}'", suite.metric));
  }
  suite.root = optional_text(root, "root");
  if (suite.root.is_relative() && !suite.root.empty()) suite.root = file.parent_path() / suite.root;
  suite.config = optional_text(root, "config");
  suite.sequences = read_sequences(root);
  suite.sources = read_sources(root);
  const auto published = root.find("published");
  if (!published) return suite;
  for (const YamlEntry& entry : published->items()) {
    suite.published.push_back(read_row(entry, suite));
  }
  return suite;
}

std::optional<fs::path> find_sequence(const fs::path& root, const SuiteSequence& sequence) {
  for (const fs::path& path : sequence.paths) {
    std::error_code ignored;
    if (fs::exists(root / path, ignored)) return root / path;
  }
  return std::nullopt;
}

}  // namespace imslam::system

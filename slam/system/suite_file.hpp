#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace imslam::system {

/// A figure that a suite compares systems by.
struct SuiteFigure {
  std::string key;    ///< in the blocks of metrics.json
  std::string name;   ///< in suite files and csv
  std::string title;  ///< with its unit
  std::string latex;  ///< likewise, ready for a paper
  int digits = 3;     ///< after the point
};

/// kitti: t_rel [%] and r_rel [deg/100 m] over stretches of 100..800 m; euroc: ATE [m] after SE(3)
/// alignment. Throws InputError(kUsage) for another word.
const std::vector<SuiteFigure>& suite_figures(const std::string& metric);

struct SuiteSequence {
  std::string name;                          ///< e.g. "01", "MH_01_easy"; also of its folder
  std::vector<std::filesystem::path> paths;  ///< below the root, the first that exists counts
};

using SuiteValues = std::vector<std::optional<double>>;

/// What others have reported.
struct PublishedRow {
  std::string name;
  std::string source;               ///< its mark in Suite::sources
  std::vector<SuiteValues> values;  ///< [figure][sequence]; empty: not published
  SuiteValues averages;             ///< [figure], as published
};

/// Sequences that are run, evaluated and tabulated together.
struct Suite {
  std::string name;
  std::string metric;          ///< see suite_figures()
  std::filesystem::path root;  ///< relative ones are meant from the suite file; empty: not given
  std::string config;          ///< below all other options; empty: none
  std::vector<SuiteSequence> sequences;
  std::vector<std::pair<std::string, std::string>> sources;  ///< mark, meaning
  std::vector<PublishedRow> published;

  const std::vector<SuiteFigure>& figures() const { return suite_figures(metric); }
};

/// Reads a suite:
///
///   name: KITTI odometry
///   metric: kitti                        # or euroc
///   root: /data/kitti                    # optional
///   config: kitti                        # optional, a config file or the name of a shipped one
///   sequences:
///     - {name: "01", path: sequences/01} # or path: [A, B], the first that exists
///   sources: {P: where row P is from}
///   published:
///     - {name: Other, source: P, average: {t_rel: 5.45, r_rel: 5.97}}
///     - {name: Third, source: P, t_rel: [1.2], r_rel: [0.3]}  # one per sequence, "-": unknown
///
/// An average that is not given is the mean, if all values are. Throws InputError(kUsage)
/// "file:line: ..." for anything else, naming the nearest known key.
Suite read_suite(const std::filesystem::path& file);

/// The folder of a sequence below `root`; none: it is not there.
std::optional<std::filesystem::path> find_sequence(const std::filesystem::path& root,
                                                   const SuiteSequence& sequence);

}  // namespace imslam::system

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "slam/evaluation/evaluate.hpp"
#include "slam/evaluation/metric.hpp"
#include "slam/evaluation/statistics.hpp"

namespace imslam::evaluation {

/// A file that was compared, as it is named beside the figures.
struct ComparedFile {
  std::string name;
  std::string sha256;
};

/// One line of the table: a metric with all its statistics, or the reason why there are none.
struct ErrorRow {
  std::string metric;     ///< "ATE", "RPE"
  std::string condition;  ///< "SE(3) aligned", "1 m, all pairs", ...
  std::string unit;       ///< "m", "deg"
  std::size_t pairs = 0;
  std::optional<Statistics> stats;
  std::string reason;  ///< where stats is empty
};

/// Everything `imslam eval` says about two files.
struct EvaluationTable {
  ComparedFile reference;
  ComparedFile estimate;
  AssociationOptions association;
  std::vector<ErrorRow> rows;
  Evaluation evaluation;
};

/// The rows that the literature uses, each measured by measure(); the vertical for yaw as in
/// `options`.
std::vector<ErrorRow> standard_rows(const MatchedPaths& matched, const EvaluationOptions& options);

std::string as_text(const EvaluationTable& table);   ///< aligned, for a terminal
std::string as_text(const Drift& drift);             ///< KITTI, by length and by speed
std::string as_csv(const EvaluationTable& table);    ///< one line per row and figure
std::string as_latex(const EvaluationTable& table);  ///< a booktabs tabular, to be pasted

/// The keys of metrics.json; what is not determined is null.
nlohmann::ordered_json as_json(const Evaluation& evaluation);
nlohmann::ordered_json as_json(const Statistics& stats);
nlohmann::ordered_json as_json(const Drift& drift);

}  // namespace imslam::evaluation

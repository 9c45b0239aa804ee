#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "datasets/trajectory_file.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/text.hpp"
#include "slam/evaluation/evaluate.hpp"
#include "slam/evaluation/evaluation_text.hpp"
#include "slam/evaluation/metric.hpp"
#include "slam/evaluation/names.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

namespace imslam::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFooter =
    "Files: TUM (time_s tx ty tz qx qy qz qw), KITTI (3x4 per line), EuRoC (csv, ns); found by\n"
    "themselves. Figures are those of evo and of the KITTI devkit. Exit code 8: impossible.\n"
    "\n"
    "Examples:\n"
    "  imslam eval truth.tum estimate.tum                   all figures in one table\n"
    "  imslam eval truth.tum estimate.tum --metric ape --align se3 --json\n"
    "  imslam eval truth.csv estimate.tum --metric rpe --delta 1 --unit meters --all-pairs\n"
    "  imslam eval poses/00.txt 00.txt --metric kitti       t_rel, r_rel\n"
    "  imslam eval truth.tum est.tum --metric ape --align se3 --save-zip est.zip   (for evo_res)\n"
    "  imslam eval truth.tum camera.tum --T-body-eval \"0.1 0 0 0 0 0 1\"            another frame";

struct EvalRequest {
  std::string reference;
  std::string estimate;
  std::string metric;  ///< "ape", "rpe", "kitti" or empty: everything
  evaluation::MetricOptions figure;
  evaluation::EvaluationOptions options;
  std::string T_body_eval;
  std::string vertical = "auto";
  bool json = false;
  std::string csv;
  std::string latex;
  std::string zip;
  bool force = false;
};

[[noreturn]] void fail_usage(const std::string& message) {
  throw InputError(message, ExitCode::kUsage);
}

/// "tx ty tz qx qy qz qw", or the 12 or 16 numbers of a matrix row by row, in a file or as they
/// are.
Eigen::Matrix4d parse_transform(const std::string& given) {
  std::string text = given;
  std::error_code none;
  if (std::filesystem::is_regular_file(given, none)) text = read_file(given, 1U << 16U);
  for (char& c : text) {
    if (c == ',' || c == '\n' || c == '[' || c == ']' || c == ';') c = ' ';
  }
  std::vector<double> n;
  for (const std::string_view word : split_blanks(text)) {
    const auto number = parse_double(word);
    if (!number) fail_usage("--T-body-eval: '" + std::string(word) + "' is not a number");
    n.push_back(*number);
  }
  if (n.size() == 7) {
    const Eigen::Quaterniond q(n[6], n[3], n[4], n[5]);
    if (!(q.norm() > 1e-6)) fail_usage("--T-body-eval: the quaternion is zero");
    return evaluation::rigid(q.normalized().toRotationMatrix(), {n[0], n[1], n[2]});
  }
  if (n.size() != 12 && n.size() != 16) {
    fail_usage(
        "--T-body-eval: expected 7 numbers (tx ty tz qx qy qz qw) or a matrix of 12 or 16, "
        "found " +
        std::to_string(n.size()));
  }
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topRows<3>() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(n.data());
  return T;
}

/// The yaw axis: KITTI worlds are those of the first camera, y down; all others have z up.
Eigen::Vector3d vertical_of(const std::string& name, const PosePath& path) {
  if (name == "x") return Eigen::Vector3d::UnitX();
  if (name == "y") return Eigen::Vector3d::UnitY();
  if (name == "auto" && !path.has_stamps()) return -Eigen::Vector3d::UnitY();
  return Eigen::Vector3d::UnitZ();
}

void warn_all(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) log::warn("{}", warning);
}

void write_result(const std::string& file, bool force, const std::string& content) {
  if (!force && std::filesystem::exists(file)) {
    throw InputError(file + ": exists already; choose another name or give --force",
                     ExitCode::kOutput);
  }
  write_file_atomic(file, content);
}

void print(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }
void print(const Json& json) { print(json.dump(2) + "\n"); }

Json files_block(const EvalRequest& request) {
  return {
      {"reference", {{"file", request.reference}, {"sha256", sha256_of_file(request.reference)}}},
      {"estimate", {{"file", request.estimate}, {"sha256", sha256_of_file(request.estimate)}}}};
}

Json matching_block(const evaluation::MatchedPaths& m) {
  return {{"matched", m.estimate.size()},       {"reference_poses", m.reference_poses},
          {"estimate_poses", m.estimate_poses}, {"coverage", m.coverage},
          {"time_coverage", m.time_coverage},   {"warnings", m.warnings}};
}

std::string name_of_alignment(evaluation::Alignment kind) {
  for (const auto& [name, value] : evaluation::alignment_names()) {
    if (value == kind) return name;
  }
  return "none";
}

/// evo's console format: title, blank line, statistics by name.
std::string evo_text(const evaluation::MetricResult& result) {
  const evaluation::Statistics& s = result.stats;
  const std::map<std::string, double> sorted = {
      {"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.std},
      {"min", s.min},   {"max", s.max},   {"sse", s.sse}};
  std::string text = result.title + "\n\n";
  for (const auto& [name, value] : sorted) {
    char line[64];
    std::snprintf(line, sizeof(line), "%10s\t%.6f\n", name.c_str(), value);
    text += line;
  }
  return text;
}

struct Paths {
  PosePath reference;
  PosePath estimate;
};

evaluation::EvaluationTable table_of(const EvalRequest& request, const Paths& paths) {
  evaluation::EvaluationTable table;
  table.reference = {request.reference, sha256_of_file(request.reference)};
  table.estimate = {request.estimate, sha256_of_file(request.estimate)};
  table.association = request.options.association;
  table.evaluation = evaluation::evaluate(paths.reference, paths.estimate, request.options);
  return table;
}

void write_tables(const EvalRequest& request, const evaluation::EvaluationTable& table) {
  if (!request.csv.empty()) write_result(request.csv, request.force, as_csv(table));
  if (!request.latex.empty()) write_result(request.latex, request.force, as_latex(table));
}

ExitCode run_all(const EvalRequest& request, const Paths& paths) {
  if (!request.zip.empty()) fail_usage("--save-zip stores one result: give --metric ape or rpe");
  evaluation::EvaluationTable table = table_of(request, paths);
  warn_all(table.evaluation.warnings);
  table.rows = evaluation::standard_rows(
      evaluation::prepare(paths.reference, paths.estimate, request.options), request.options);
  write_tables(request, table);
  if (request.json) {
    Json json = files_block(request);
    json.update(as_json(table.evaluation));
    json["kitti"] = as_json(table.evaluation.kitti);
    json["sub_trajectories"] = as_json(table.evaluation.sub_trajectories);
    print(json);
  } else {
    print(as_text(table));
  }
  return table.evaluation.ate_se3_rmse_m ? ExitCode::kOk : ExitCode::kEvaluation;
}

ExitCode run_kitti(const EvalRequest& request, const Paths& paths) {
  if (!request.zip.empty()) fail_usage("--save-zip stores errors: give --metric ape or rpe");
  const auto table = table_of(request, paths);
  warn_all(table.evaluation.warnings);
  write_tables(request, table);
  const evaluation::Drift& drift = table.evaluation.kitti;
  if (request.json) {
    Json json = as_json(drift);
    json.update(files_block(request));
    json["path_length_m"] = table.evaluation.path_length_m;
    json["matched"] = table.evaluation.matched;
    json["coverage"] = table.evaluation.coverage;
    json["warnings"] = table.evaluation.warnings;
    print(json);
  } else if (!drift.segments.empty()) {
    print(evaluation::as_text(drift));
  }
  if (!drift.segments.empty()) return ExitCode::kOk;
  log::error(
      "KITTI drift needs a path of more than 100 m, this one has {:.1f} m; see the shorter "
      "segments printed without --metric",
      table.evaluation.path_length_m);
  return ExitCode::kEvaluation;
}

ExitCode run_figure(const EvalRequest& request, const Paths& paths) {
  const auto matched = evaluation::prepare(paths.reference, paths.estimate, request.options);
  warn_all(matched.warnings);
  const auto result = evaluation::measure(matched, request.figure);
  if (result.series.dropped > 0) {
    log::warn("{} pairs without motion of the reference were left out", result.series.dropped);
  }
  evaluation::EvaluationTable table;
  table.reference.name = request.reference;
  table.estimate.name = request.estimate;
  table.evaluation.matched = matched.estimate.size();
  table.evaluation.coverage = matched.coverage;
  table.rows.push_back({request.figure.relative ? "RPE" : "APE",
                        name_of_alignment(request.figure.alignment.kind),
                        evaluation::unit_of(request.figure.relation), result.series.errors.size(),
                        result.stats, ""});
  write_tables(request, table);
  if (!request.zip.empty()) {
    write_result(request.zip, request.force,
                 evo_archive(evo_result(matched, request.figure, result)));
  }
  if (!request.json) {
    print(evo_text(result));
    return ExitCode::kOk;
  }
  Json json = {{"metric", request.metric},
               {"title", result.title},
               {"unit", evaluation::unit_of(request.figure.relation)},
               {"align", name_of_alignment(request.figure.alignment.kind)},
               {"scale", result.aligned.transform.scale},
               {"pairs", result.series.errors.size()},
               {"stats", as_json(result.stats)}};
  json.update(matching_block(matched));
  json.update(files_block(request));
  print(json);
  return ExitCode::kOk;
}

ExitCode evaluate_files(EvalRequest request) {
  const Paths paths = {datasets::read_trajectory(request.reference),
                       datasets::read_trajectory(request.estimate)};
  if (!request.T_body_eval.empty()) {
    request.options.T_body_eval = parse_transform(request.T_body_eval);
  }
  request.options.up_reference = vertical_of(request.vertical, paths.reference);
  request.options.up_estimate = vertical_of(request.vertical, paths.estimate);
  request.figure.alignment.up_reference = request.options.up_reference;
  request.figure.alignment.up_estimate = request.options.up_estimate;
  request.figure.relative = request.metric == "rpe";
  if (request.metric.empty()) return run_all(request, paths);
  if (request.metric == "kitti") return run_kitti(request, paths);
  return run_figure(request, paths);
}

template <typename Value>
CLI::Option* add_choice(CLI::App& eval,
                        const std::string& name,
                        Value& value,
                        const std::map<std::string, Value>& choices,
                        const std::string& help) {
  return eval
      .add_option_function<std::string>(
          name, [&value, &choices](const std::string& word) { value = choices.at(word); }, help)
      ->check(CLI::IsMember(choices));
}

const std::map<std::string, evaluation::Plane>& plane_names() {
  static const std::map<std::string, evaluation::Plane> kNames = {{"xy", evaluation::Plane::kXy},
                                                                  {"xz", evaluation::Plane::kXz},
                                                                  {"yz", evaluation::Plane::kYz}};
  return kNames;
}

void add_figure_options(CLI::App& eval, EvalRequest& request) {
  auto& figure = request.figure;
  const std::string group = "One figure (with --metric)";
  eval.add_option("--metric", request.metric, "ape, rpe or kitti; without it: everything")
      ->check(CLI::IsMember({"ape", "rpe", "kitti"}))
      ->group(group);
  add_choice(eval, "--align", figure.alignment.kind, evaluation::alignment_names(),
             "How the estimate is laid over the reference (none)")
      ->group(group);
  eval.add_option("--align-first", figure.alignment.first, "Fit to the first N pairs only")
      ->group(group);
  add_choice(eval, "--relation", figure.relation, evaluation::relation_names(),
             "What is measured (translation_part)")
      ->group(group);
  eval.add_option("--delta", figure.delta.delta, "rpe: how far apart the poses of a pair are (1)")
      ->group(group);
  add_choice(eval, "--unit", figure.delta.unit, evaluation::delta_unit_names(),
             "rpe: unit of --delta (frames)")
      ->group(group);
  eval.add_flag("--all-pairs", figure.delta.all_pairs, "rpe: overlapping pairs from every pose")
      ->group(group);
  eval.add_option("--delta-tol", figure.delta.relative_tolerance,
                  "rpe, all pairs: relative tolerance of --delta (0.1)")
      ->group(group);
  eval.add_flag("--pairs-from-reference", figure.delta.pairs_from_reference,
                "rpe: measure --delta on the reference")
      ->group(group);
  add_choice(eval, "--project", figure.projection, plane_names(), "Lay both paths into a plane")
      ->group(group);
}

void add_matching_options(CLI::App& eval, EvalRequest& request) {
  auto& association = request.options.association;
  const std::string group = "Matching";
  eval.add_option("--t-max-diff", association.max_difference_s,
                  "Largest difference of matching stamps [s] (0.01)")
      ->group(group);
  eval.add_option("--t-offset", association.offset_s, "Added to the estimate's stamps [s]")
      ->group(group);
  eval.add_option("--t-start", association.start_s, "First reference stamp [s]")->group(group);
  eval.add_option("--t-end", association.end_s, "Last reference stamp [s]")->group(group);
  eval.add_flag("--interpolate", association.interpolate,
                "Interpolate the reference instead of taking its nearest pose")
      ->group(group);
  eval.add_option("--T-body-eval", request.T_body_eval,
                  "Frame of the reference seen from that of the estimate: \"tx ty tz qx qy qz "
                  "qw\", 12 or 16 numbers, or a file")
      ->group(group);
  eval.add_option("--vertical", request.vertical,
                  "Axis of the yaw-only alignment: x, y, z or auto (KITTI: y, else z)")
      ->check(CLI::IsMember({"auto", "x", "y", "z"}))
      ->group(group);
}

void add_output_options(CLI::App& eval, EvalRequest& request) {
  const std::string group = "Output";
  eval.add_flag("--json", request.json, "One JSON object on stdout")->group(group);
  eval.add_option("--csv", request.csv, "Write the table as csv")->group(group);
  eval.add_option("--latex", request.latex, "Write the table for a paper (booktabs)")->group(group);
  eval.add_option("--save-zip", request.zip, "Write a result that evo_res reads")->group(group);
  eval.add_flag("--force", request.force, "Overwrite files")->group(group);
}

}  // namespace

void add_eval_command(CLI::App& app, Action& action) {
  auto* eval = app.add_subcommand("eval", "Compare a trajectory with a reference");
  eval->footer(kFooter);
  auto request = std::make_shared<EvalRequest>();
  eval->add_option("reference", request->reference, "Ground truth")->required();
  eval->add_option("estimate", request->estimate, "Trajectory to be judged")->required();
  add_figure_options(*eval, *request);
  add_matching_options(*eval, *request);
  add_output_options(*eval, *request);
  eval->callback([&action, request, eval] {
    action = [request, eval] {
      if (request->metric.empty()) {
        for (const char* name :
             {"--align", "--align-first", "--relation", "--delta", "--unit", "--all-pairs",
              "--delta-tol", "--pairs-from-reference", "--project"}) {
          if (eval->count(name) > 0) log::warn("{} has an effect only with --metric", name);
        }
      }
      return evaluate_files(*request);
    };
  });
}

}  // namespace imslam::app

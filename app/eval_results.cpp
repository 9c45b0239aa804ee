#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/eval_request.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/evaluation/evaluation_text.hpp"
#include "slam/evaluation/names.hpp"

namespace imslam::app {
namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void fail_usage(const std::string& message) {
  throw InputError(message, ExitCode::kUsage);
}

void warn_all(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) log::warn("{}", warning);
}

void write_result(const std::string& file, bool force, const std::string& content) {
  std::error_code ignored;  // writing says what is wrong with the name
  if (!force && std::filesystem::exists(file, ignored)) {
    throw InputError(file + ": exists already; choose another name or give --force",
                     ExitCode::kOutput);
  }
  write_file_atomic(file, content);
}

void print(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }
void print(const Json& json) {
  // Names of files may be no UTF-8.
  print(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

/// Null for what can be read once only, as a pipe.
Json sha256_block(const std::string& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) ? Json(sha256_of_file(file)) : Json();
}

Json files_block(const EvalRequest& request) {
  return {{"reference", {{"file", request.reference}, {"sha256", sha256_block(request.reference)}}},
          {"estimate", {{"file", request.estimate}, {"sha256", sha256_block(request.estimate)}}}};
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
    text += fmt::format("{:>10}\t{:.6f}\n", name, value);
  }
  return text;
}

evaluation::EvaluationTable table_of(const EvalRequest& request, const Paths& paths) {
  evaluation::EvaluationTable table;
  const auto hash = [](const Json& sha256) {
    return sha256.is_string() ? sha256.get<std::string>() : std::string();
  };
  table.reference = {request.reference, hash(sha256_block(request.reference))};
  table.estimate = {request.estimate, hash(sha256_block(request.estimate))};
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

}  // namespace

ExitCode report_evaluation(const EvalRequest& request, const Paths& paths) {
  if (request.metric.empty()) return run_all(request, paths);
  if (request.metric == "kitti") return run_kitti(request, paths);
  return run_figure(request, paths);
}

}  // namespace imslam::app

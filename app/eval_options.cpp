#include <CLI/Option.hpp>
#include <map>

#include "app/eval_request.hpp"
#include "slam/evaluation/names.hpp"

namespace imslam::app {
namespace {

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
      ->check(CLI::Range(1, 1000000000))
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

void add_eval_options(CLI::App& eval, EvalRequest& request) {
  add_figure_options(eval, request);
  add_matching_options(eval, request);
  add_output_options(eval, request);
}

}  // namespace imslam::app

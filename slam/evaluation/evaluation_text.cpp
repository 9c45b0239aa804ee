#include "slam/evaluation/evaluation_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "slam/base/error.hpp"
#include "slam/base/text.hpp"
#include "slam/evaluation/names.hpp"

namespace imslam::evaluation {
namespace {

ErrorRow row(const MatchedPaths& matched,
             const MetricOptions& options,
             const std::string& condition) {
  ErrorRow result;
  result.metric = options.relative ? "RPE" : "ATE";
  result.condition = condition;
  result.unit = unit_of(options.relation);
  try {
    const MetricResult measured = measure(matched, options);
    result.pairs = measured.series.errors.size();
    result.stats = measured.stats;
    if (options.alignment.kind == Alignment::kSim3) {
      result.condition += fmt::format(", scale {:.5f}", measured.aligned.transform.scale);
    }
  } catch (const InputError& error) {
    result.reason = error.what();
  }
  return result;
}

std::vector<double> columns_of(const Statistics& s) {
  return {s.rmse, s.mean, s.median, s.std, s.min, s.max};
}

std::string file_line(const char* role, const ComparedFile& file, std::size_t poses) {
  return fmt::format("{:<10} {} ({} poses)\n{:<10} sha256 {}\n", role, file.name, poses, "",
                     file.sha256);
}

std::string matching_line(const EvaluationTable& table) {
  const Evaluation& e = table.evaluation;
  if (!e.stamped)
    return fmt::format("{:<10} {} poses, by their order (no stamps)", "matched", e.matched);
  const std::string how =
      table.association.interpolate
          ? "reference interpolated"
          : fmt::format("stamps within {:g} s", table.association.max_difference_s);
  return fmt::format("{:<10} {} poses, coverage {:.1f} %, {:.1f} % of the reference's time, {}",
                     "matched", e.matched, 100.0 * e.coverage, 100.0 * e.time_coverage, how);
}

std::string rows_as_text(const std::vector<ErrorRow>& rows) {
  std::size_t width = 0;
  for (const ErrorRow& r : rows) width = std::max(width, r.condition.size());
  std::string text =
      fmt::format("{:<5}{:<{}}  {:>6}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}{:>8}\n", "", "", width,
                  "unit", "rmse", "mean", "median", "std", "min", "max", "pairs");
  for (const ErrorRow& r : rows) {
    text += fmt::format("{:<5}{:<{}}  {:>6}", r.metric, r.condition, width, r.unit);
    if (r.stats) {
      for (const double value : columns_of(*r.stats)) text += fmt::format("{:>11.6f}", value);
      text += fmt::format("{:>8}\n", r.pairs);
    } else {
      text += "  not defined: " + r.reason + "\n";
    }
  }
  return text;
}

std::string drift_as_text(const Drift& drift, const char* title, const char* if_empty) {
  if (drift.segments.empty()) return fmt::format("{:<30}  {}\n", title, if_empty);
  std::string text =
      fmt::format("{:<30}{:>10}{:>11}{:>15}\n", title, "segments", "t [%]", "r [deg/100m]");
  for (const DriftBin& bin : drift.by_length) {
    text += fmt::format("{:>28.1f} m{:>10}{:>11.4f}{:>15.4f}\n", bin.key, bin.count, bin.t_percent,
                        bin.r_deg_per_100m);
  }
  return text + fmt::format("{:>30}{:>10}{:>11.4f}{:>15.4f}\n", "all", drift.segments.size(),
                            drift.t_rel_percent, drift.r_rel_deg_per_100m);
}

std::string end_as_text(const Evaluation& e) {
  std::string text = "at the end                    ";
  if (e.end_error_percent) {
    text += fmt::format("  position {:.4f} % of {:.2f} m,", *e.end_error_percent, e.path_length_m);
  }
  return text + fmt::format("  rotation {:.4f} deg (motion from first to last pose)\n",
                            e.rotation_end_deg);
}

std::string interpolated_as_text(const Evaluation& e) {
  if (!e.interpolated) return "";
  const InterpolatedFigures& i = *e.interpolated;
  return fmt::format(
      "with interpolated reference     ATE SE(3) {}, RPE 1 frame {:.6f} m, {:.6f} deg "
      "({} poses)\n",
      i.ate_se3_rmse_m ? fmt::format("{:.6f} m", *i.ate_se3_rmse_m) : "not defined",
      i.rpe_frame_rmse_m, i.rpe_frame_rmse_deg, i.matched);
}

}  // namespace

std::vector<ErrorRow> standard_rows(const MatchedPaths& matched, const EvaluationOptions& options) {
  MetricOptions m;
  m.alignment.up_reference = options.up_reference;
  m.alignment.up_estimate = options.up_estimate;
  std::vector<ErrorRow> rows;
  m.alignment.kind = Alignment::kSe3;
  rows.push_back(row(matched, m, "SE(3) aligned"));
  m.alignment.kind = Alignment::kPosYaw;
  rows.push_back(row(matched, m, "yaw and translation aligned"));
  m.alignment.kind = Alignment::kSim3;
  rows.push_back(row(matched, m, "Sim(3) aligned"));
  m.alignment.kind = Alignment::kOrigin;
  rows.push_back(row(matched, m, "first pose aligned"));
  m.alignment.kind = Alignment::kSe3;
  m.relation = Relation::kRotationAngleDeg;
  rows.push_back(row(matched, m, "rotation, SE(3) aligned"));
  m.alignment.kind = Alignment::kNone;
  m.relative = true;
  for (const bool over_a_metre : {false, true}) {
    m.delta.unit = over_a_metre ? DeltaUnit::kMeters : DeltaUnit::kFrames;
    m.delta.all_pairs = over_a_metre;
    for (const Relation relation : {Relation::kTranslationPart, Relation::kRotationAngleDeg}) {
      m.relation = relation;
      rows.push_back(row(matched, m, over_a_metre ? "1 m, all pairs" : "1 frame"));
    }
  }
  return rows;
}

std::string as_text(const EvaluationTable& table) {
  const Evaluation& e = table.evaluation;
  std::string text = file_line("reference", table.reference, e.reference_poses) +
                     file_line("estimate", table.estimate, e.estimate_poses);
  text += matching_line(table);
  text += fmt::format("\n{:<10} {:.3f} m\n\n", "path", e.path_length_m);
  text += rows_as_text(table.rows) + "\n";
  text += drift_as_text(e.kitti, "KITTI, not aligned", "the path is shorter than 100 m");
  text +=
      drift_as_text(e.sub_trajectories, "10..50 % of the path", "the path has no length") + "\n";
  return text + end_as_text(e) + interpolated_as_text(e);
}

std::string as_text(const Drift& drift) {
  std::string text = drift_as_text(drift, "KITTI, not aligned", "the path is shorter than 100 m");
  if (drift.by_speed.empty()) return text;
  text +=
      fmt::format("\n{:<30}{:>10}{:>11}{:>15}\n", "by speed", "segments", "t [%]", "r [deg/100m]");
  for (const DriftBin& bin : drift.by_speed) {
    text += fmt::format("{:>26.1f} m/s{:>10}{:>11.4f}{:>15.4f}\n", bin.key, bin.count,
                        bin.t_percent, bin.r_deg_per_100m);
  }
  return text;
}

std::string as_csv(const EvaluationTable& table) {
  std::string text = "metric,condition,unit,pairs,rmse,mean,median,std,min,max,sse\n";
  for (const ErrorRow& r : table.rows) {
    text += fmt::format("{},{},{},{}", r.metric, csv_field(r.condition), r.unit, r.pairs);
    if (r.stats) {
      for (const double value : columns_of(*r.stats)) text += fmt::format(",{}", value);
      text += fmt::format(",{}\n", r.stats->sse);
    } else {
      text += ",,,,,,,\n";
    }
  }
  const Evaluation& e = table.evaluation;
  const auto drift = [&](const char* name, const Drift& d) {
    if (d.segments.empty()) return;
    text += fmt::format("{},t_rel,%,{},,{},,,,,\n", name, d.segments.size(), d.t_rel_percent);
    text += fmt::format("{},r_rel,deg/100m,{},,{},,,,,\n", name, d.segments.size(),
                        d.r_rel_deg_per_100m);
  };
  drift("KITTI", e.kitti);
  drift("sub-trajectories", e.sub_trajectories);
  return text;
}

std::string as_latex(const EvaluationTable& table) {
  std::string text = fmt::format(
      "% {} against {}: {} poses matched, coverage {:.1f} %\n"
      "\\begin{{tabular}}{{lllrrrrr}}\n\\toprule\n"
      "Metric & Condition & Unit & RMSE & Mean & Median & Std & Max \\\\\n\\midrule\n",
      table.estimate.name, table.reference.name, table.evaluation.matched,
      100.0 * table.evaluation.coverage);
  for (const ErrorRow& r : table.rows) {
    text += fmt::format("{} & {} & {}", r.metric, latex_text(r.condition), latex_text(r.unit));
    if (r.stats) {
      const Statistics& s = *r.stats;
      text += fmt::format(" & {:.4f} & {:.4f} & {:.4f} & {:.4f} & {:.4f} \\\\\n", s.rmse, s.mean,
                          s.median, s.std, s.max);
    } else {
      text += " & -- & -- & -- & -- & -- \\\\\n";
    }
  }
  if (!table.evaluation.kitti.segments.empty()) {
    const Drift& d = table.evaluation.kitti;
    text +=
        fmt::format("KITTI & $t_\\mathrm{{rel}}$ & \\% & & {:.4f} & & & \\\\\n", d.t_rel_percent);
    text += fmt::format("KITTI & $r_\\mathrm{{rel}}$ & deg/100\\,m & & {:.4f} & & & \\\\\n",
                        d.r_rel_deg_per_100m);
  }
  return text + "\\bottomrule\n\\end{tabular}\n";
}

}  // namespace imslam::evaluation

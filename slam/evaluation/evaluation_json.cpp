#include <nlohmann/json.hpp>

#include "slam/evaluation/evaluation_text.hpp"

namespace imslam::evaluation {
namespace {

using Json = nlohmann::ordered_json;

Json nullable(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json bins(const std::vector<DriftBin>& drift_bins, const char* key) {
  Json list = Json::array();
  for (const DriftBin& bin : drift_bins) {
    list.push_back({{key, bin.key},
                    {"segments", bin.count},
                    {"t_percent", bin.t_percent},
                    {"r_deg_per_100m", bin.r_deg_per_100m}});
  }
  return list;
}

}  // namespace

Json as_json(const Statistics& stats) {
  return {{"rmse", stats.rmse}, {"mean", stats.mean}, {"median", stats.median}, {"std", stats.std},
          {"min", stats.min},   {"max", stats.max},   {"sse", stats.sse}};
}

Json as_json(const Drift& drift) {
  const bool any = !drift.segments.empty();
  return {{"t_rel_percent", any ? Json(drift.t_rel_percent) : Json(nullptr)},
          {"r_rel_deg_per_100m", any ? Json(drift.r_rel_deg_per_100m) : Json(nullptr)},
          {"segments", drift.segments.size()},
          {"by_length", bins(drift.by_length, "length_m")},
          {"by_speed", bins(drift.by_speed, "speed_mps")}};
}

Json as_json(const Evaluation& e) {
  Json json = {{"ate_se3_rmse_m", nullable(e.ate_se3_rmse_m)},
               {"ate_posyaw_rmse_m", nullable(e.ate_posyaw_rmse_m)},
               {"ate_sim3_rmse_m", nullable(e.ate_sim3_rmse_m)},
               {"scale", nullable(e.scale)},
               {"rpe_1m_rmse_m", nullable(e.rpe_1m_rmse_m)},
               {"rpe_frame_rmse_m", e.rpe_frame_rmse_m},
               {"rpe_frame_rmse_deg", e.rpe_frame_rmse_deg},
               {"t_rel_percent", nullable(e.t_rel_percent)},
               {"r_rel_deg_per_100m", nullable(e.r_rel_deg_per_100m)},
               {"end_error_percent", nullable(e.end_error_percent)},
               {"rotation_end_deg", e.rotation_end_deg},
               {"path_length_m", e.path_length_m},
               {"matched", e.matched},
               {"reference_poses", e.reference_poses},
               {"estimate_poses", e.estimate_poses},
               {"coverage", e.coverage},
               {"time_coverage", e.time_coverage},
               {"warnings", e.warnings}};
  if (e.interpolated) {
    json["interpolated"] = {{"matched", e.interpolated->matched},
                            {"ate_se3_rmse_m", nullable(e.interpolated->ate_se3_rmse_m)},
                            {"rpe_frame_rmse_m", e.interpolated->rpe_frame_rmse_m},
                            {"rpe_frame_rmse_deg", e.interpolated->rpe_frame_rmse_deg}};
  }
  return json;
}

}  // namespace imslam::evaluation

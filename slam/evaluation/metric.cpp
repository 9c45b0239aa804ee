#include "slam/evaluation/metric.hpp"

#include <cmath>

#include "slam/evaluation/names.hpp"
#include "slam/evaluation/path_checks.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

namespace imslam::evaluation {
namespace {

/// The Euler angle of R = Rz(c) Ry(b) Rx(a) about one axis.
double euler_angle(const Eigen::Matrix3d& R, int axis) {
  if (axis == 2) return std::atan2(R(1, 0), R(0, 0));
  if (axis == 1) return std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  return std::atan2(R(2, 1), R(2, 2));
}

/// The positions of some poses only.
PosePath thinned(const PosePath& path, const std::vector<std::size_t>& kept) {
  PosePath thin;
  for (const std::size_t i : kept) thin.poses.push_back(path.poses[i]);
  return thin;
}

const char* plane_name(Plane plane) {
  const char* const names[] = {"", "xy", "xz", "yz"};
  return names[static_cast<int>(plane)];
}

}  // namespace

PosePath projected(const PosePath& path, Plane plane) {
  if (plane == Plane::kNone) return path;
  const int normal = plane == Plane::kXy ? 2 : plane == Plane::kXz ? 1 : 0;
  PosePath flat = path;
  for (Eigen::Matrix4d& pose : flat.poses) {
    Eigen::Vector3d p = position(pose);
    p(normal) = 0.0;
    const Eigen::AngleAxisd turn(euler_angle(rotation(pose), normal),
                                 Eigen::Vector3d::Unit(normal));
    pose = rigid(turn.toRotationMatrix(), p);
  }
  return flat;
}

MatchedPaths prepare(const PosePath& reference,
                     const PosePath& estimate,
                     const EvaluationOptions& options) {
  options.validate();
  require_evaluable(reference);
  require_evaluable(estimate);
  MatchedPaths matched =
      associate(reference, moved_to_frame(estimate, options.T_body_eval), options.association);
  for (std::string& warning : frame_warnings(matched)) {
    matched.warnings.push_back(std::move(warning));
  }
  return matched;
}

MetricResult measure(const MatchedPaths& matched, const MetricOptions& options) {
  MetricResult result;
  result.title =
      evo_title(options.relation, options.alignment, options.relative ? &options.delta : nullptr,
                plane_name(options.projection));
  result.aligned = align(matched.reference, matched.estimate, options.alignment);
  result.reference = projected(matched.reference, options.projection);
  result.aligned.estimate = projected(result.aligned.estimate, options.projection);
  result.series = options.relative ? relative_errors(result.reference, result.aligned.estimate,
                                                     options.relation, options.delta)
                                   : absolute_errors(result.reference, result.aligned.estimate,
                                                     options.relation);
  result.stats = statistics(result.series.errors);
  return result;
}

EvoResult evo_result(const MatchedPaths& matched,
                     const MetricOptions& options,
                     const MetricResult& result) {
  EvoResult evo;
  evo.title = result.title;
  evo.label =
      std::string(options.relative ? "RPE" : "APE") + " (" + unit_of(options.relation) + ")";
  evo.reference_name = matched.reference.source;
  evo.estimate_name = matched.estimate.source;
  evo.stats = result.stats;
  evo.errors = result.series.errors;
  if (options.alignment.kind != Alignment::kNone) {
    evo.T_alignment = result.aligned.transform.matrix();
  }
  if (!matched.reference.has_stamps()) return evo;
  // evo thins both paths out to the first pose and those of the pairs before it measures them.
  std::vector<std::size_t> kept = result.series.poses;
  if (options.relative) kept.insert(kept.begin(), 0);
  const std::vector<double> along_reference = distances_along(thinned(result.reference, kept));
  const std::vector<double> along_estimate =
      distances_along(thinned(result.aligned.estimate, kept));
  for (std::size_t i = options.relative ? 1 : 0; i < kept.size(); ++i) {
    const double stamp = matched.estimate.stamps_s[kept[i]];
    evo.timestamps_s.push_back(stamp);
    evo.seconds_from_start_s.push_back(stamp - matched.estimate.stamps_s.front());
    evo.distances_from_start_m.push_back(along_reference[i]);
    evo.distances_m.push_back(along_estimate[i]);
  }
  return evo;
}

}  // namespace imslam::evaluation

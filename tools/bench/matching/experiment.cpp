#include "tools/bench/matching/experiment.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"
#include "vo_net/corner_detector.hpp"
#include "vo_net/klt_matcher.hpp"

namespace imslam::bench {
namespace {

using vo::MatchKind;

constexpr double kLeastKnown = 0.2;

struct Queries {
  std::vector<Eigen::Vector2d> points;
  std::vector<Eigen::Vector2d> truth;  ///< displacements [px]
};

/// What is visible in the clean scene and still is, with the same displacement.
Queries visible_queries(const MatchScene& clean,
                        const MatchScene& scene,
                        MatchKind kind,
                        const std::vector<Eigen::Vector2d>& corners) {
  Queries queries;
  for (const Eigen::Vector2d& corner : corners) {
    const int row = static_cast<int>(corner.y());
    const int column = static_cast<int>(corner.x());
    const TrueMatch before = true_match(clean, kind, row, column);
    const TrueMatch match = true_match(scene, kind, row, column);
    if (before.state != training::MatchState::kVisible ||
        match.state != training::MatchState::kVisible || match.du != before.du ||
        match.dv != before.dv) {
      continue;
    }
    queries.points.push_back(corner);
    queries.truth.emplace_back(match.du, match.dv);
  }
  return queries;
}

double normalised(const Eigen::Vector2d& error, const Eigen::Matrix2d& scale, MatchKind kind) {
  if (kind == MatchKind::kStereo) return std::abs(error.x()) / std::sqrt(scale(0, 0));
  return std::sqrt(error.dot(scale.inverse() * error));
}

PointResult judged(const PointMatch& match, const Eigen::Vector2d& truth, MatchKind kind) {
  PointResult result;
  result.answered = match.answered;
  result.accepted = match.accepted;
  result.score = match.score;
  const Eigen::Vector2d error = match.displacement - truth;
  result.error = kind == MatchKind::kStereo ? std::abs(error.x()) : error.norm();
  result.normalised_error = result.confidence = NAN;
  if (match.uncertainty) {
    result.normalised_error = normalised(error, match.uncertainty->scale, kind);
    result.confidence = match.uncertainty->confidence;
  }
  return result;
}

/// One kind under all methods, for the results to be put together.
struct Column {
  MatchKind kind;
  std::string method;
  std::vector<PointResult> results;
};
using Columns = std::vector<Column>;

Columns run(const MatchScene& clean,
            const MatchScene& scene,
            const std::vector<Eigen::Vector2d>& corners,
            const std::vector<std::unique_ptr<Method>>& methods) {
  Columns columns;
  const GrayImage left0 = gray_image(scene, scene.views.left0);
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    if (!scene.has(kind)) continue;
    const GrayImage other = gray_image(scene, matched_view(scene, kind));
    const Queries queries = visible_queries(clean, scene, kind, corners);
    for (const auto& method : methods) {
      if (method->names(kind).empty()) continue;
      for (const Answer& answer : method->match(kind, left0, other, queries.points)) {
        columns.push_back({kind, answer.method, {}});
        for (std::size_t i = 0; i < answer.matches.size(); ++i) {
          columns.back().results.push_back(judged(answer.matches[i], queries.truth[i], kind));
        }
      }
    }
  }
  return columns;
}

void append(const Columns& columns,
            MatchKind kind,
            const std::string& method,
            std::vector<PointResult>& results) {
  for (const Column& column : columns) {
    if (column.kind != kind || column.method != method) continue;
    results.insert(results.end(), column.results.begin(), column.results.end());
  }
}

/// Share of the pixels of left0 whose truth is known, of the kind that knows more.
double known_share(const MatchScene& scene) {
  const auto known = [](const std::vector<training::MatchState>& states) {
    return static_cast<std::size_t>(states.size()) -
           static_cast<std::size_t>(
               std::count(states.begin(), states.end(), training::MatchState::kNone));
  };
  const training::Triplet& t = scene.views;
  return static_cast<double>(std::max(known(t.flow_state), known(t.disparity_state))) /
         static_cast<double>(t.left0.size());
}

}  // namespace

std::vector<Eigen::Vector2d> query_points(const MatchScene& scene) {
  const vo::KltOptions klt;
  vo::ImagePyramid pyramid;
  pyramid.build(gray_image(scene, scene.views.left0), 2, klt.smoothing);
  vo::CornerOptions options;
  // Where truth is sparse, more corners, so that as many as usual have one.
  options.max_points = static_cast<int>(klt.max_points / std::max(known_share(scene), kLeastKnown));
  options.min_quality = klt.min_quality;
  options.margin = kQueryBorder;
  return detect_corners(pyramid, {}, options);
}

std::vector<Measurement> measure(const DataSet& data,
                                 const std::vector<Trial>& trials,
                                 const std::vector<std::unique_ptr<Method>>& methods,
                                 std::uint64_t seed) {
  const std::size_t scenes = data.scenes.size();
  std::vector<std::vector<Eigen::Vector2d>> corners;
  for (const MatchScene& scene : data.scenes) corners.push_back(query_points(scene));
  std::vector<Columns> columns(trials.size() * scenes);
  parallel_for(columns.size(), [&](std::size_t i) {
    const std::size_t scene = i % scenes;
    const Trial& trial = trials[i / scenes];
    const Random random = Random(seed).fork(scene);
    const MatchScene& clean = data.scenes[scene];
    columns[i] = run(clean, spoiled(clean, trial.condition, trial.severity, random), corners[scene],
                     methods);
  });
  std::vector<Measurement> measurements;
  for (const MatchKind kind : {MatchKind::kFlow, MatchKind::kStereo}) {
    const bool known = std::any_of(data.scenes.begin(), data.scenes.end(),
                                   [&](const MatchScene& scene) { return scene.has(kind); });
    if (!known) continue;
    for (std::size_t t = 0; t < trials.size(); ++t) {
      for (const auto& method : methods) {
        for (const std::string& name : method->names(kind)) {
          measurements.push_back({kind, trials[t], name, {}});
          for (std::size_t s = 0; s < scenes; ++s) {
            append(columns[t * scenes + s], kind, name, measurements.back().results);
          }
        }
      }
    }
  }
  return measurements;
}

}  // namespace imslam::bench

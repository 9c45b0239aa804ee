#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/bench/matching/conditions.hpp"
#include "tools/bench/matching/method.hpp"
#include "tools/bench/matching/quality.hpp"
#include "tools/bench/matching/scene.hpp"

namespace imslam::bench {

struct DataSet {
  std::string name;
  std::vector<MatchScene> scenes;
};

/// A condition at one severity; severity 0 is the clean data.
struct Trial {
  Condition condition;
  int severity = 0;
};

/// What one method did with one kind of all scenes of a data set under one trial.
struct Measurement {
  vo::MatchKind kind = vo::MatchKind::kFlow;
  Trial trial;
  std::string method;
  std::vector<PointResult> results;  ///< of all query points, scene after scene
};

/// A query point must stay so far away from the border of left0 [px].
inline constexpr int kQueryBorder = 20;

/// Corners of the clean left image: so many that the truth of about 600 is known.
std::vector<Eigen::Vector2d> query_points(const MatchScene& scene);

/// Every method on every trial. The queries are the corners that are visible in the clean scene and
/// still are after the spoiling, with the same displacement (points that a moving patch covers do
/// not count): the same ones for all methods. In the order kind, trial, method. Scenes run in
/// parallel; the result does not depend on it.
std::vector<Measurement> measure(const DataSet& data,
                                 const std::vector<Trial>& trials,
                                 const std::vector<std::unique_ptr<Method>>& methods,
                                 std::uint64_t seed);

}  // namespace imslam::bench

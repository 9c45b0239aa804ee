#pragma once

#include <string>
#include <vector>

#include "slam/report/run_content.hpp"

namespace imslam::report {

/// Rows of a trajectory or series that the page shows at most; longer ones are thinned.
inline constexpr std::size_t kMaxRows = 20000;

/// The run in the form that template/*.js reads, and what the page's head needs.
struct PageData {
  std::string json;     ///< valid JSON without a non-finite number; not yet escaped for a script
  std::string dataset;  ///< metrics.dataset, or the folder's name
  std::string date;     ///< of the manifest; empty if it has none
  std::vector<std::string> notes;  ///< those of the run and what turned out to be unusable here
};

/// The layout of the JSON:
///
///   name, dataset, date    texts
///   notes                  [texts]
///   metrics                metrics.json, null where a number is not finite
///   trajectories           {graph|vo|truth: {count, time, position, rotation}}
///                          base64 of float32: seconds since the first pose of the graph, xyz [m]
///                          from `origin`, quaternion xyzw
///   origin                 [x y z]
///   map                    {count, total, center, scale, points (int16 xyz), intensity (uint8)}
///   series                 {column: base64 of float32, NaN where there is no value}
///   rpe                    [{length_m, graph|vo: {low, q1, median, q3, high, max, rmse, count}}]
PageData page_data(const RunContent& run);

}  // namespace imslam::report

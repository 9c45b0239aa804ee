#pragma once

#include <string>

#include "slam/report/run_content.hpp"

namespace imslam::report {

enum class View { kTop, kSide };  ///< world x-y and x-z

/// A drawing of truth, VO and graph, equal scale on both axes, with a metre grid. Empty string if
/// there is no trajectory.
///
/// `standalone`: with its own style (light and dark), to be saved as a file; otherwise the page's
/// style applies. Pixels from metres, for moving markers, in the root's attributes:
///   x_px = data-x0 + data-scale * horizontal,   y_px = data-y0 - data-scale * vertical
std::string trajectory_svg(const RunContent& run, View view, bool standalone);

}  // namespace imslam::report

#pragma once

#include <filesystem>
#include <string>

namespace imslam::report::testing {

/// A run folder as slam/system writes it, made of formulas: a hand-held camera that circles in a
/// furnished room for 60 s, visual odometry that drifts, a graph that drifts less.
struct SyntheticRun {
  std::string dataset = "synthetic_room";
  bool truth = true;
  bool map = true;
  int frames = 1200;          ///< at 20 Hz
  double length_scale = 1.0;  ///< 60 gives a street instead of a room
};

void write_synthetic_run(const std::filesystem::path& folder, const SyntheticRun& options = {});

}  // namespace imslam::report::testing

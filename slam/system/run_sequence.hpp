#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "datasets/sequence.hpp"
#include "slam/system/run_evaluation.hpp"
#include "slam/system/run_metrics.hpp"
#include "slam/system/slam_options.hpp"
#include "slam/system/slam_result.hpp"
#include "slam/system/slam_system.hpp"

namespace imslam::system {

/// Which frames to run over, and who is told how far it is.
struct RunRequest {
  std::size_t first_frame = 0;
  std::size_t last_frame = 0;  ///< not included; 0: all
  /// Called after each frame; false stops in good order: what was seen so far is the result.
  std::function<bool(std::size_t done, std::size_t total)> keep_going;
  FrameObserver observe;                    ///< told about each frame; may be empty
  WindowObserver observe_window;            ///< told about the sliding window; may be empty
  const Networks* networks = nullptr;       ///< instead of those that the options name; see there
  std::optional<DeviceCalibration> device;  ///< likewise
};

struct RunOutcome {
  SlamResult result;
  RunSummary summary;
  std::optional<RunEvaluation> evaluation;  ///< where the sequence has truth
  bool stopped = false;                     ///< by keep_going
};

/// Throws InputError(kUsage) if the frames do not exist, InputError(kData) if the sequence is
/// shorter than two frames or its IMU covers none of them, InputError(kModel) if the front end
/// lacks its weights: what can be said before any output.
void check_request(const datasets::Sequence& sequence,
                   const SlamOptions& options,
                   const RunRequest& request);

/// Runs the SLAM system over a sequence and compares the result with its truth.
/// Throws what check_request() throws, what reading the sequence throws, and
/// InputError(kTrackingLost) if not a single motion was measured.
RunOutcome run_sequence(datasets::Sequence& sequence,
                        const SlamOptions& options,
                        const RunRequest& request);

}  // namespace imslam::system

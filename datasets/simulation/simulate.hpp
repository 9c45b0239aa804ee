#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "datasets/simulation/options.hpp"

namespace imslam::simulation {

struct SimulationSummary {
  std::size_t frames = 0;  ///< stereo pairs
  std::size_t imu_samples = 0;
  double distance_m = 0.0;  ///< travelled by the body
  double render_s = 0.0;    ///< mean time to render one pair with truth
  double write_s = 0.0;     ///< mean time to encode and write one pair with truth
  std::string textures;     ///< the bank that was used
};

using SimulationProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Simulates a sequence and writes it to the folder `out` in EuRoC's ASL layout:
///
///   mav0/cam0, mav0/cam1                  raw images, sensor.yaml
///   mav0/imu0                             readings, sensor.yaml with the data sheet's noise
///   mav0/state_groundtruth_estimate0      pose, velocity and true bias at every IMU stamp
///   mav0/depth0/data/<ns>.png             (truth_depth) depth [m] along the left camera's axis, 0:
///                                         sky; 4 x 8 bit whose bytes are one little-endian float32
///   mav0/flow0/data/<ns>.png              (truth_flow) 3 x 16 bit B, G, R = valid, row, column:
///                                         displacement = (value - 32768) / 64 px to the next frame
///   simulation.yaml                       all options; `imslam simulate --config` takes it
///
/// Both truth formats can be read with OpenCV's IMREAD_UNCHANGED. Memory does not grow with the
/// length, apart from the motion's 10 control poses per second.
/// Throws InputError: kUsage for bad options, kOutput where the folder is not empty (without
/// options.force and an earlier simulation in it) or cannot be written.
SimulationSummary simulate(const SimulationOptions& options,
                           const std::filesystem::path& out,
                           const SimulationProgress& progress = {});

}  // namespace imslam::simulation

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/finding.hpp"
#include "datasets/sequence.hpp"

namespace imslam {
class Config;
}

namespace imslam::datasets {

struct CheckOptions {
  std::string format = "auto";  ///< of the recording, see open_sequence()
  bool all_images = false;      ///< decode every image, not a sample
  int image_samples = 50;       ///< pairs that are decoded otherwise, evenly spread
  int vision_frames = 300;      ///< frames for the checks of geometry and clock; 0: none

  void describe(Config& config);
  void validate() const;
};

/// Everything there is to say about a recording: files line by line, rates, gaps, pairing, images,
/// units, gravity, and the geometry and clocks as far as images and gyro tell. Never throws on bad
/// data: whatever is wrong becomes a finding, and the rest is checked as far as possible.
/// InputError(kUsage) for bad options only.
std::vector<Finding> check_sequence(const std::filesystem::path& folder,
                                    const CheckOptions& options = {});

/// Whether left and right are exchanged: over the first `frames` complete frames the disparities
/// are negative or the rows do not fit, while both are fine the other way round. About 15 ms per
/// frame. Empty if all is well or nothing can be seen.
std::optional<Finding> check_stereo_order(Sequence& sequence, std::size_t frames = 10);

}  // namespace imslam::datasets

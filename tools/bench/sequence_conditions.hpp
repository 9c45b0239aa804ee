#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace imslam::bench {

/// A way in which all images of a recording get worse, at severities 1 to 5.
///
///   motion_blur   straight smears, {4, 8, 12, 16, 21} px, another direction in every stereo pair
///   dark          {0.4, 0.25, 0.15, 0.08, 0.04} of the light, read noise 2 grey levels, shot noise
///                 0.02 per grey level
///   brighter      every second second {1.25, 1.6, 2, 2.5, 4} times as bright; above 255 is lost
///   darker        every second second {0.8, 0.6, 0.4, 0.25, 0.15} times as bright
///   noise         {5, 10, 15, 20, 30} grey levels, independent in every pixel and image
///   moving        {3, 6, 12, 20, 30} textured things of an eighth of the width that cross the view
///                 at 2 to 12 px per frame, in front of the scene
struct SequenceCondition {
  std::string name;
  /// Makes `folder` a spoiled copy of the EuRoC folder `base`; the same severity, the same damage.
  void spoil(const std::filesystem::path& base,
             const std::filesystem::path& folder,
             int severity) const;
};

std::vector<SequenceCondition> sequence_conditions();

}  // namespace imslam::bench

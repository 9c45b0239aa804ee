#pragma once

#include "slam/base/random.hpp"
#include "tools/bench/matching/scene.hpp"

namespace imslam::bench {

/// A piece of the left image, mirrored, that stands in front of the scene: its left border lies
/// `disparity` to the left in the right view and it moves by a flow of its own.
struct MovingPatch {
  double x = 0.0, y = 0.0;  ///< upper left pixel in left0, whole numbers
  double disparity = 1.0;   ///< [px] positive, in quarters like the flow
  double flow_u = 0.0, flow_v = 0.0;
  int source_x = 0, source_y = 0;  ///< upper left pixel of the piece
  int width = 0, height = 0;       ///< [px] pixel centres from 0 to width - 1 are covered
};

/// Draws patches of about an eighth of the width that move by 4 to 24 px in any direction and stand
/// 1 to 10 px of disparity in front of what they cover. The first patches are the same whatever the
/// count.
std::vector<MovingPatch> draw_patches(const MatchScene& scene, int count, const Random& random);

/// Puts them into all views, later ones over earlier ones, and corrects the truth: pixels of left0
/// under a patch get the patch's displacement, pixels that a patch covers in another view become
/// kHidden there.
void add_patches(const std::vector<MovingPatch>& patches, MatchScene& scene);

}  // namespace imslam::bench

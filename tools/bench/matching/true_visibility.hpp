#pragma once

#include "tools/bench/matching/scene.hpp"

namespace imslam::bench {

/// Truths that land closer than this to one another but come from displacements that differ by more
/// are not of one surface [px].
inline constexpr double kSameSurface = 1.0;

/// Finds out which points of a kind are occluded, from dense truth alone: only states that are
/// kVisible change.
///
///   kOutside   beyond the centres of the other view's border pixels
///   kHidden    lands in a pixel in which a nearer point lands whose displacement differs by more
///              than kSameSurface
///
/// Nearer is what has the greater disparity; in a scene without stereo truth it is not known who
/// hides whom, and both are called hidden: fewer points to measure with, but none that are wrong.
void mark_hidden(vo::MatchKind kind, MatchScene& scene);

}  // namespace imslam::bench

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "slam/base/random.hpp"
#include "tools/bench/matching/scene.hpp"

namespace imslam::bench {

inline constexpr std::size_t kSeverities = 5;

/// A way in which matching gets harder, at severities 1 to 5. left0 and right0 are taken at one
/// instant, left0 and left1 with one camera; all images end up in whole grey levels.
struct Condition {
  const char* name;
  const char* unit;                        ///< of the values
  std::array<double, kSeverities> values;  ///< what the severities mean
  /// `random` depends on the scene only: severities differ in strength, not in luck.
  void (*spoil)(MatchScene& scene, double value, const Random& random);
};

/// motion_blur       [px] length of a straight smear; its direction is drawn anew for each instant
/// dark              [share of the light] read noise 2 grey levels, shot noise 0.02 per grey level
/// brighter, darker  [factor] of right0 and left1 against left0: a step of the exposure; what
///                   exceeds 255 is lost
/// noise             [grey levels] sigma, independent in every pixel and image
/// moving            [patches] of moving_patches.hpp, with corrected truth
std::vector<Condition> conditions();

/// What a scene becomes. Severity 0: the scene as it is.
MatchScene spoiled(const MatchScene& scene,
                   const Condition& condition,
                   int severity,
                   const Random& random);

}  // namespace imslam::bench

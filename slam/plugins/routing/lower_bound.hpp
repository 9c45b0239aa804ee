#pragma once

#include "slam/plugins/routing/distances.hpp"

namespace imslam::routing {

/// What no longest tour can go below.
struct LowerBound {
  double farthest = 0.0;  ///< there and back to the farthest city
  double share = 0.0;     ///< the least length of all tours together over the number of agents
  double value() const { return farthest > share ? farthest : share; }
};

/// farthest: only where no detour can be shorter, as in the plane without rounding; else 0. share:
/// Held and Karp's 1-trees over all cities, in which the depot may have any degree, raised by
/// `steps` of their ascent; 0 where one way is not the other, or more than Distances::kTableCities
/// cities.
///
/// All tours together are a connected graph with two edges at every city but the depot. Without
/// city k, which is visited on the way, it is connected still: so it holds a spanning tree of the
/// others and two edges at k.
LowerBound lower_bound(const Distances& distances, int depot, int agents, int steps = 100);

}  // namespace imslam::routing

#pragma once

#include <cstdint>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/plugins/routing/distances.hpp"
#include "slam/plugins/routing/stop_rule.hpp"

namespace imslam::routing {

/// The lower level of the problem: one agent's closed tour through given cities.
///
///   start      along a Hilbert curve where there are coordinates, else to the nearest not yet seen
///   descend    2-opt, Or-opt, Or-3opt        (see tour_search.hpp)
///   disturb    `kicks` per city, none by default
///
/// The same cities in the same order give the same tour.
struct TourSolverOptions {
  double kicks = 0.0;  ///< of the iterated search, per city
};

/// `cities` in visiting order, first the one that was first; `symmetric`: of the instance.
std::vector<int> solve_tour(const Instance& instance,
                            bool symmetric,
                            const std::vector<int>& cities,
                            const TourSolverOptions& options = {});

/// The same for a single tour until `stop`.
std::vector<int> solve_tour(const Instance& instance,
                            bool symmetric,
                            const std::vector<int>& cities,
                            const StopRule& stop,
                            Random& random);

/// The same from the tour as it is, by `kicks` per city after the descent.
std::vector<int> polish_tour(const Instance& instance,
                             bool symmetric,
                             const std::vector<int>& tour,
                             double kicks = 0.0);

/// What searches start from.
std::vector<std::int32_t> first_tour(const Distances& distances);

/// Of the closed tour, by Instance::distance.
double tour_length(const Instance& instance, const std::vector<int>& cities);

}  // namespace imslam::routing

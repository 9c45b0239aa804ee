#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "slam/plugins/routing/allocation_network.hpp"
#include "slam/plugins/routing/min_max_search.hpp"
#include "slam/plugins/routing/solution.hpp"
#include "slam/plugins/routing/stop_rule.hpp"

namespace imslam::routing {

/// How tours are found.
enum class Method {
  kInsertion,      ///< each city where it lengthens the longest tours least, farthest first
  kNetwork,        ///< the network shares out, one tour search per agent: the paper's way
  kSearch,         ///< insertion, then ChainedSearch until the end
  kNetworkSearch,  ///< the better of the network's likeliest and insertion, then ChainedSearch
};
const std::vector<std::string>& method_names();  ///< "insertion", ... in this order

struct SolveOptions {
  int agents = 1;
  Method method = Method::kSearch;
  double time_s = 1.0;  ///< of the searches; 0: no limit but iterations
  TimeOf time_of = TimeOf::kWall;
  std::int64_t iterations = 0;  ///< of the searches; the same tours each time; 0: no limit
  int chains = 1;               ///< searches side by side that share the best; not shown to help
  int seed = 1;
  int draws = 16;  ///< kNetwork: allocations drawn besides the likeliest; the best counts
  // First temperatures of the search; see MinMaxOptions.
  double heat = MinMaxOptions().heat;  ///< from insertion
  double network_heat = 3.0;           ///< from the network's answer, which is better

  void validate() const;  ///< Throws InputError(kUsage) naming key, value and bound.
};

/// Searches end `time_s` after the call (or earlier), the others when they are done. One agent is a
/// plain travelling salesman, whatever the method. Throws InputError(kUsage) on bad options and
/// where the network is asked about cities without coordinates, or for another number of agents.
Solution solve(const Instance& instance,
               const SolveOptions& options,
               const AllocationNetwork<float>* network);

}  // namespace imslam::routing

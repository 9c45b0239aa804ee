#pragma once

#include <cstdint>
#include <vector>

#include "slam/plugins/routing/min_max_search.hpp"
#include "slam/plugins/routing/stop_rule.hpp"

namespace imslam::routing {

/// Several MinMaxSearches from one start, side by side on the threads.
///
///   schedule   T = mean edge per agent times heat at the start ... times cold at the end
///   exchange   now and then all go on from the fleet of the one with the least sum of powers
///
/// What ends by iterations (of each chain) ends the same on any number of threads.
class ChainedSearch {
 public:
  ChainedSearch(const Fleet& start,
                const Neighbours& near,
                const MinMaxOptions& options,
                int chains,
                const Random& random);

  void run(const StopRule& stop);
  std::int64_t iterations() const { return iterations_; }  ///< of each chain
  /// The fleet with the shortest longest tour that was seen.
  const Fleet& best() const;

 private:
  std::int64_t first_round(const StopRule& stop) const;
  void exchange();

  std::vector<MinMaxSearch> chains_;
  MinMaxOptions options_;
  double edge_;
  std::int64_t iterations_ = 0;
};

}  // namespace imslam::routing

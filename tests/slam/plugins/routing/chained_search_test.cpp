#include "slam/plugins/routing/chained_search.hpp"

#include <gtest/gtest.h>

#include <string>

#include "slam/base/parallel.hpp"

namespace imslam::routing {
namespace {

constexpr int kCities = 120;
constexpr int kAgents = 4;
constexpr int kNear = 10;

struct Found {
  std::vector<std::vector<int>> tours;
  double longest = 0.0;
};

Found searched(int chains, int threads, std::int64_t iterations, std::uint64_t seed = 1) {
  Random random(8);
  const Instance instance = random_instance(kCities, random);
  const Distances distances(instance);
  const Neighbours near(distances, kNear);
  const Fleet start = MinMaxSearch::greedy(Fleet(distances, 0, kAgents), near);
  set_thread_count(threads);
  ChainedSearch search(start, near, MinMaxOptions(), chains, Random(seed));
  search.run(StopRule::after_iterations(iterations));
  set_thread_count(0);
  EXPECT_EQ(search.iterations(), iterations);
  return {search.best().tours(), search.best().length(search.best().longest())};
}

TEST(ChainedSearch, FindsTheSameOnAnyNumberOfThreads) {
  EXPECT_EQ(searched(3, 1, 3000).tours, searched(3, 2, 3000).tours);
}

TEST(ChainedSearch, ChainsHaveChancesOfTheirOwn) {
  EXPECT_NE(searched(1, 1, 300).tours, searched(4, 1, 300).tours);
}

TEST(ChainedSearch, TheBestOfAllChainsCounts) {
  // Three iterations each are too few to exchange: the first chain is that of a search alone.
  int shorter = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const double alone = searched(1, 1, 3, seed).longest;
    const double best = searched(8, 1, 3, seed).longest;
    EXPECT_LE(best, alone);
    if (best < alone) ++shorter;
  }
  EXPECT_GE(shorter, 10);
}

TEST(ChainedSearch, ChainsThatExchangeFindShorterOnesThanOneDoes) {
  double alone = 0.0, together = 0.0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    alone += searched(1, 1, 1000, seed).longest / 10.0;
    together += searched(6, 1, 1000, seed).longest / 10.0;
  }
  RecordProperty("alone", std::to_string(alone));
  RecordProperty("together", std::to_string(together));
  EXPECT_LT(together, 0.995 * alone);
}

TEST(MinMaxSearch, GoesOnFromAnothersFleet) {
  Random random(8);
  const Instance instance = random_instance(kCities, random);
  const Distances distances(instance);
  const Neighbours near(distances, kNear);
  const Fleet start = MinMaxSearch::greedy(Fleet(distances, 0, kAgents), near);
  MinMaxSearch first(start, near, MinMaxOptions(), Random(1));
  MinMaxSearch second(start, near, MinMaxOptions(), Random(2));
  first.anneal(2000, 1e-3, 1e-4);
  second.go_on_from(first);
  EXPECT_EQ(first.sum_of_powers(), second.sum_of_powers());
  second.anneal(1, 1e-9, 1e-9);  // a step downhill, or none
  EXPECT_LE(second.sum_of_powers(), first.sum_of_powers());
}

}  // namespace
}  // namespace imslam::routing

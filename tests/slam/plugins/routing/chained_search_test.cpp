#include "slam/plugins/routing/chained_search.hpp"

#include <gtest/gtest.h>

#include "slam/base/parallel.hpp"

namespace imslam::routing {
namespace {

constexpr int kCities = 120;
constexpr int kAgents = 4;
constexpr int kNear = 10;

std::vector<std::vector<int>> searched(int chains, int threads, std::int64_t iterations) {
  Random random(8);
  const Instance instance = random_instance(kCities, random);
  const Distances distances(instance);
  const Neighbours near(distances, kNear);
  const Fleet start = MinMaxSearch::greedy(Fleet(distances, 0, kAgents), near);
  set_thread_count(threads);
  ChainedSearch search(start, near, MinMaxOptions(), chains, Random(1));
  search.run(StopRule::after_iterations(iterations));
  set_thread_count(0);
  EXPECT_EQ(search.iterations(), iterations);
  return search.best().tours();
}

TEST(ChainedSearch, FindsTheSameOnAnyNumberOfThreads) {
  EXPECT_EQ(searched(3, 1, 3000), searched(3, 2, 3000));
}

TEST(ChainedSearch, ChainsHaveChancesOfTheirOwn) {
  EXPECT_NE(searched(1, 1, 300), searched(4, 1, 300));
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

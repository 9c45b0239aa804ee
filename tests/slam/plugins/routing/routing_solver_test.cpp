#include "slam/plugins/routing/routing_solver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <thread>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/plugins/routing/lower_bound.hpp"
#include "tests/slam/plugins/routing/exhaustive.hpp"

namespace imslam::routing {
namespace {

SolveOptions by_iterations(int agents, std::int64_t iterations, Method method = Method::kSearch) {
  SolveOptions options;
  options.agents = agents;
  options.method = method;
  options.time_s = 0.0;
  options.iterations = iterations;
  return options;
}

Instance numbered(int cities, std::uint64_t seed) {
  Random random(seed);
  return random_instance(cities, random);
}

AllocationNetwork<float> untrained(int agents) {
  Random random(3);
  return {agents, AllocationSizes(), random};
}

TEST(RoutingSolver, FindsTheLeastLongestTourOfFewCities) {
  for (int cities = 4; cities <= 8; ++cities) {
    for (const int agents : {2, 3}) {
      const Instance instance = numbered(cities, static_cast<std::uint64_t>(cities));
      const double found = solve(instance, by_iterations(agents, 3000), nullptr).longest();
      EXPECT_NEAR(found, testing::least_longest_tour(instance, agents), 1e-6)
          << cities << " cities, " << agents << " agents";
    }
  }
}

TEST(RoutingSolver, FindsItWhereDistancesKnowNoLaw) {
  for (const int agents : {2, 3}) {
    Random random(5);
    Instance instance = testing::lawless_instance(7, random);
    instance.depot = 3;
    const double found = solve(instance, by_iterations(agents, 5000), nullptr).longest();
    EXPECT_NEAR(found, testing::least_longest_tour(instance, agents), 1e-5);
  }
}

// Some roads are not there: a million in the table.
TEST(RoutingSolver, GoesAroundRoadsThatAreNotThere) {
  constexpr double kNoRoad = 1e6;
  for (const int agents : {1, 2}) {
    Random random(5);
    Instance instance = testing::lawless_instance(7, random);
    for (const std::size_t entry : {1U, 10U, 20U, 30U, 37U, 45U}) instance.matrix[entry] = kNoRoad;
    const double shortest = testing::least_longest_tour(instance, agents);
    ASSERT_LT(shortest, kNoRoad);
    EXPECT_LT(solve(instance, by_iterations(agents, 5000), nullptr).longest(), 1.02 * shortest)
        << agents;
  }
}

// measured() throws unless each city is visited once.
TEST(RoutingSolver, EveryMethodVisitsEveryCityOnceAndNotUnderTheBound) {
  const Instance instance = numbered(60, 2);
  const AllocationNetwork<float> network = untrained(4);
  const double bound = lower_bound(Distances(instance), 0, 4).value();
  for (const Method method :
       {Method::kInsertion, Method::kNetwork, Method::kSearch, Method::kNetworkSearch}) {
    const Solution solution = solve(instance, by_iterations(4, 2000, method), &network);
    EXPECT_EQ(solution.tours.size(), 4U);
    EXPECT_GE(solution.longest(), bound - 1e-6);
  }
  const double searched = solve(instance, by_iterations(4, 2000), nullptr).longest();
  const double inserted =
      solve(instance, by_iterations(4, 2000, Method::kInsertion), nullptr).longest();
  EXPECT_LT(searched, inserted);
}

TEST(RoutingSolver, MoreAgentsThanCitiesStayAtHome) {
  const Instance instance = numbered(4, 1);
  const Solution solution = solve(instance, by_iterations(100, 200), nullptr);
  EXPECT_EQ(solution.tours.size(), 100U);
  double farthest = 0.0;
  for (int city = 1; city < 4; ++city) {
    farthest = std::max(farthest, 2.0 * instance.distance(0, city));
  }
  EXPECT_NEAR(solution.longest(), farthest, 1e-6);
  EXPECT_GE(std::count(solution.lengths.begin(), solution.lengths.end(), 0.0), 97);
}

TEST(RoutingSolver, TwoCitiesAndOneAgentAreEnough) {
  const Instance instance = numbered(2, 1);
  EXPECT_NEAR(solve(instance, by_iterations(1, 10), nullptr).longest(),
              2.0 * instance.distance(0, 1), 1e-9);
  EXPECT_NEAR(solve(instance, by_iterations(2, 10), nullptr).longest(),
              2.0 * instance.distance(0, 1), 1e-9);
}

TEST(RoutingSolver, TakesCitiesAtOnePlace) {
  Instance instance;
  instance.points.assign(20, {1.0, 1.0});
  EXPECT_EQ(solve(instance, by_iterations(3, 500), nullptr).longest(), 0.0);
}

TEST(RoutingSolver, IterationsGiveTheSameToursOnAnyNumberOfThreads) {
  const Instance instance = numbered(150, 7);
  const auto tours = [&](int threads) {
    set_thread_count(threads);
    const Solution solution = solve(instance, by_iterations(5, 3000), nullptr);
    set_thread_count(0);
    return solution.tours;
  };
  EXPECT_EQ(tours(1), tours(2));
}

TEST(RoutingSolver, SaysWhatItCannotDo) {
  const Instance instance = numbered(10, 7);
  const AllocationNetwork<float> network = untrained(4);
  EXPECT_THROW(solve(instance, by_iterations(0, 10), nullptr), InputError);
  EXPECT_THROW(solve(instance, by_iterations(2, 0), nullptr), InputError);
  EXPECT_THROW(solve(instance, by_iterations(3, 10, Method::kNetwork), &network), InputError);
  Random random(1);
  const Instance table = testing::lawless_instance(6, random);
  EXPECT_THROW(solve(table, by_iterations(4, 10, Method::kNetwork), &network), InputError);
}

TEST(LowerBound, IsBelowTheOptimumAndNotFarBelow) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Instance instance = numbered(8, seed);
    const double optimum = testing::least_longest_tour(instance, 2);
    const double bound = lower_bound(Distances(instance), 0, 2).value();
    EXPECT_LE(bound, optimum + 1e-6);
    EXPECT_GT(bound, 0.75 * optimum);
  }
}

TEST(LowerBound, OfOneAgentIsNearTheShortestTour) {
  const Instance instance = numbered(12, 3);
  std::vector<int> cities(12);
  std::iota(cities.begin(), cities.end(), 0);
  const double shortest = testing::held_karp(instance, cities);
  const double bound = lower_bound(Distances(instance), 0, 1, 300).value();
  EXPECT_LE(bound, shortest + 1e-6);
  EXPECT_GT(bound, 0.97 * shortest);
}

TEST(StopRule, CountsProcessorTimeOnlyWhileTheProcessorWorks) {
  const auto processor = clock_from_now(TimeOf::kProcessor);
  const auto wall = clock_from_now(TimeOf::kWall);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LT(processor(), 0.5 * wall());
  EXPECT_GE(wall(), 0.05);
}

TEST(StopRule, EndsByTheClockOrTheIterationsWhicheverIsFirst) {
  double now = 0.0;
  const auto clock = [&] { return now; };
  const StopRule both(10.0, 100, clock);
  EXPECT_EQ(both.progress(0), 0.0);
  EXPECT_EQ(both.progress(50), 0.5);
  now = 8.0;
  EXPECT_EQ(both.progress(50), 0.8);
  EXPECT_GE(both.part(0.5).progress(0), 1.0);
  EXPECT_GE(both.progress(100), 1.0);
  now = 10.0;
  EXPECT_GE(both.progress(0), 1.0);
  EXPECT_EQ(StopRule::after_iterations(4).progress(1), 0.25);
  EXPECT_THROW(StopRule(0.0, 0, clock), ContractError);
}

}  // namespace
}  // namespace imslam::routing

#include "slam/plugins/routing/tour_solver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "slam/plugins/routing/tour_array.hpp"
#include "tests/slam/plugins/routing/exhaustive.hpp"

namespace imslam::routing {
namespace {

std::vector<int> all_cities(const Instance& instance) {
  std::vector<int> cities(static_cast<std::size_t>(instance.city_count()));
  std::iota(cities.begin(), cities.end(), 0);
  return cities;
}

void expect_permutation(std::vector<int> found, std::vector<int> expected) {
  std::sort(found.begin(), found.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(found, expected);
}

TEST(TourArray, GoesBackThroughAnyChanges) {
  Random random(4);
  std::vector<std::int32_t> order(20);
  std::iota(order.begin(), order.end(), 0);
  TourArray tour(order);
  const auto pick = [&](int low, int high) { return static_cast<int>(random.integer(low, high)); };
  for (int repeat = 0; repeat < 200; ++repeat) {
    for (int change = 0; change < 5; ++change) {
      const int start = pick(0, 19), left = pick(1, 9), right = pick(1, 9);
      const auto at = [&](int k) { return tour.at((start + k) % 20); };
      const int a = at(0), b = at(1), c = at(left), d = at(left + 1), e = at(left + right),
                f = at(left + right + 1);
      if (random.chance(0.5)) {
        tour.swap_segments(a, b, c, d, e, f);
        EXPECT_TRUE(tour.next(a) == d && tour.next(e) == b && tour.next(c) == f);
      } else {
        tour.exchange(a, b, e, f);
        EXPECT_TRUE(tour.next(a) == e || tour.previous(a) == e);
        EXPECT_TRUE(tour.next(b) == f || tour.previous(b) == f);
      }
    }
    tour.go_back();
    for (int i = 0; i < 20; ++i) {
      EXPECT_TRUE(tour.next(i) == (i + 1) % 20 || tour.previous(i) == (i + 1) % 20);
    }
  }
}

TEST(TourSolver, FindsTheShortestTourOfFewCities) {
  for (int cities = 3; cities <= 12; ++cities) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      Random random(seed);
      const Instance instance = random_instance(cities, random);
      const std::vector<int> tour = solve_tour(instance, true, all_cities(instance), {50.0});
      expect_permutation(tour, all_cities(instance));
      EXPECT_EQ(tour.front(), 0);
      EXPECT_NEAR(tour_length(instance, tour), testing::held_karp(instance, all_cities(instance)),
                  1e-5)
          << cities << " cities, seed " << seed;
    }
  }
}

TEST(TourSolver, FindsTheShortestTourWhereOneWayIsNotTheOther) {
  for (int cities = 3; cities <= 11; ++cities) {
    Random random(static_cast<std::uint64_t>(cities));
    const Instance instance = testing::lawless_instance(cities, random);
    const std::vector<int> tour = solve_tour(instance, false, all_cities(instance), {200.0});
    expect_permutation(tour, all_cities(instance));
    EXPECT_NEAR(tour_length(instance, tour), testing::held_karp(instance, all_cities(instance)),
                1e-5)
        << cities;
  }
}

TEST(TourSolver, IsNearTheShortestTourOnManyCities) {
  Random random(8);
  const Instance instance = random_instance(2000, random);
  const std::vector<int> fast = solve_tour(instance, true, all_cities(instance));
  expect_permutation(fast, all_cities(instance));
  // Shortest tours of that many: 0.7124 sqrt(n) and 2 % for the border (Johnson, McGeoch 1996).
  const double expected = 1.02 * 0.7124 * std::sqrt(2000.0);
  EXPECT_LT(tour_length(instance, fast), 1.1 * expected);
  EXPECT_GT(tour_length(instance, fast), 0.98 * expected);
}

TEST(TourSolver, TheGainsThatItCountsAreThoseOfTheTour) {
  Random random(8);
  const Instance instance = random_instance(60, random);
  const double plain = tour_length(instance, solve_tour(instance, true, all_cities(instance)));
  const double kicked =
      tour_length(instance, solve_tour(instance, true, all_cities(instance), {100.0}));
  EXPECT_LE(kicked, plain + 1e-9);
}

TEST(TourSolver, TakesCitiesAtOnePlace) {
  Instance instance;
  instance.points.assign(30, {0.5, 0.5});
  const std::vector<int> tour = solve_tour(instance, true, all_cities(instance), {5.0});
  expect_permutation(tour, all_cities(instance));
}

/// Cities on a square lattice.
Instance lattice(int side, double step) {
  Instance instance;
  for (int i = 0; i < side * side; ++i) {
    instance.points.push_back({step * (i % side), step * (i / side)});
  }
  return instance;
}

// Too many for a table. On a lattice many changes gain nothing but the rounding of large numbers,
// which must not go on for ever.
TEST(TourSolver, EndsOnLargeCoordinates) {
  constexpr int kSide = 56;
  for (const double step : {1e9 / 7.0, 1e12 / 7.0}) {
    const Instance instance = lattice(kSide, step);
    ASSERT_GT(instance.city_count(), Distances::kTableCities);
    const std::vector<int> tour = solve_tour(instance, true, all_cities(instance), {0.1});
    expect_permutation(tour, all_cities(instance));
    EXPECT_LT(tour_length(instance, tour), 1.15 * kSide * kSide * step);
  }
}

TEST(TourSolver, EndsWhereDistancesAreNotFinite) {
  const Instance instance = lattice(5, 1e39);  // more than a float holds
  expect_permutation(solve_tour(instance, true, all_cities(instance), {5.0}), all_cities(instance));
}

}  // namespace
}  // namespace imslam::routing

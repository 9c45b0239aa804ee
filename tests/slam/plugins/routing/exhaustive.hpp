#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "slam/plugins/routing/instance.hpp"

namespace imslam::routing::testing {

/// Shortest closed tour through `cities` by dynamic programming over sets (Held, Karp 1962).
inline double held_karp(const Instance& instance, const std::vector<int>& cities) {
  const std::size_t n = cities.size();
  if (n < 2) return 0.0;
  const std::size_t sets = std::size_t{1} << (n - 1);
  std::vector<double> best(sets * n, 1e300);
  const auto d = [&](std::size_t a, std::size_t b) {
    return instance.distance(cities[a], cities[b]);
  };
  for (std::size_t k = 1; k < n; ++k) best[(std::size_t{1} << (k - 1)) * n + k] = d(0, k);
  for (std::size_t set = 1; set < sets; ++set) {
    for (std::size_t last = 1; last < n; ++last) {
      if ((set >> (last - 1) & 1U) == 0 || best[set * n + last] > 1e299) continue;
      for (std::size_t next = 1; next < n; ++next) {
        if ((set >> (next - 1) & 1U) != 0) continue;
        double& slot = best[(set | std::size_t{1} << (next - 1)) * n + next];
        slot = std::min(slot, best[set * n + last] + d(last, next));
      }
    }
  }
  double shortest = 1e300;
  for (std::size_t k = 1; k < n; ++k) {
    shortest = std::min(shortest, best[(sets - 1) * n + k] + d(k, 0));
  }
  return shortest;
}

/// Least longest tour over all ways to share the cities out, each tour by held_karp().
inline double least_longest_tour(const Instance& instance, int agents) {
  std::vector<int> others;
  for (int i = 0; i < instance.city_count(); ++i) {
    if (i != instance.depot) others.push_back(i);
  }
  std::size_t ways = 1;
  for (std::size_t i = 0; i < others.size(); ++i) ways *= static_cast<std::size_t>(agents);
  double least = 1e300;
  for (std::size_t way = 0; way < ways; ++way) {
    std::vector<std::vector<int>> shares(static_cast<std::size_t>(agents), {instance.depot});
    std::size_t rest = way;
    for (const int city : others) {
      shares[rest % shares.size()].push_back(city);
      rest /= shares.size();
    }
    double longest = 0.0;
    for (const auto& share : shares) longest = std::max(longest, held_karp(instance, share));
    least = std::min(least, longest);
  }
  return least;
}

/// Distances without any law: neither symmetric nor a metric.
inline Instance lawless_instance(int cities, Random& random) {
  Instance instance;
  instance.name = "lawless";
  instance.metric = Metric::kMatrix;
  for (int i = 0; i < cities * cities; ++i) {
    instance.matrix.push_back(i % (cities + 1) == 0 ? 0.0 : random.uniform(1.0, 10.0));
  }
  return instance;
}

}  // namespace imslam::routing::testing

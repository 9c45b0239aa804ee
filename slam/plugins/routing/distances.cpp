#include "slam/plugins/routing/distances.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "slam/base/parallel.hpp"
#include "slam/plugins/routing/point_grid.hpp"

namespace imslam::routing {
namespace {

constexpr int kGridCities = 400;  ///< from which on looking at all others takes longer than a grid

std::vector<int> all_cities(const Instance& instance) {
  std::vector<int> cities(static_cast<std::size_t>(instance.city_count()));
  std::iota(cities.begin(), cities.end(), 0);
  return cities;
}

std::vector<int> all_but(int place, int count) {
  std::vector<int> others;
  for (int i = 0; i < count; ++i) {
    if (i != place) others.push_back(i);
  }
  return others;
}

std::vector<Point> points_of(const Distances& distances) {
  std::vector<Point> points;
  for (int i = 0; i < distances.count(); ++i) {
    points.push_back(distances.instance().points[static_cast<std::size_t>(distances.city(i))]);
  }
  return points;
}

/// The nearest of `others` in front; equal distances in the order of the numbers.
void put_nearest_first(const Distances& distances, int place, int count, std::vector<int>& others) {
  std::vector<std::pair<double, int>> ranked;
  ranked.reserve(others.size());
  for (const int other : others) {
    if (other != place) ranked.emplace_back(distances(other, place), other);
  }
  const auto middle =
      ranked.begin() + std::min<std::ptrdiff_t>(count, static_cast<std::ptrdiff_t>(ranked.size()));
  std::partial_sort(ranked.begin(), middle, ranked.end());
  others.clear();
  for (auto i = ranked.begin(); i != middle; ++i) others.push_back(i->second);
}

}  // namespace

Distances::Distances(const Instance& instance, std::vector<int> cities, bool symmetric)
    : instance_(instance), cities_(std::move(cities)), symmetric_(symmetric) {
  const std::size_t n = cities_.size();
  if (count() > kTableCities) return;
  table_.resize(n * n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < (symmetric ? i : n); ++j) {
      table_[i * n + j] = static_cast<float>(instance.distance(cities_[i], cities_[j]));
      if (symmetric) table_[j * n + i] = table_[i * n + j];
    }
  }
}

Distances::Distances(const Instance& instance)
    : Distances(instance, all_cities(instance), instance.symmetric()) {}

Neighbours::Neighbours(const Distances& distances, int count)
    : count_(std::min(count, distances.count() - 1)) {
  const int n = distances.count();
  places_.resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(count_));
  const bool by_grid = n >= kGridCities && distances.instance().metric != Metric::kMatrix;
  const std::vector<Point> points = by_grid ? points_of(distances) : std::vector<Point>();
  const PointGrid grid(points);
  const auto find = [&](std::size_t i) {
    const int place = static_cast<int>(i);
    std::vector<int> others = by_grid ? grid.around(points[i], count_ + 1) : all_but(place, n);
    put_nearest_first(distances, place, count_, others);
    std::copy(others.begin(), others.end(),
              places_.begin() + static_cast<std::ptrdiff_t>(i) * count_);
  };
  if (by_grid) {
    parallel_for(static_cast<std::size_t>(n), find);
  } else {
    for (int i = 0; i < n; ++i) find(static_cast<std::size_t>(i));
  }
}

}  // namespace imslam::routing

#include "slam/plugins/routing/tour_solver.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "slam/plugins/routing/point_grid.hpp"
#include "slam/plugins/routing/tour_search.hpp"

namespace imslam::routing {
namespace {

constexpr int kNear = 10;         ///< places that each is held against
constexpr int kNearestUpTo = 200; ///< cities: more by the curve, if there are coordinates

std::vector<std::int32_t> nearest_first_tour(const Distances& distances) {
  const int n = distances.count();
  std::vector<std::int32_t> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = 0; i + 2 < order.size(); ++i) {
    auto nearest = order.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    double best = distances(order[i], *nearest);
    for (auto candidate = nearest + 1; candidate != order.end(); ++candidate) {
      const double distance = distances(order[i], *candidate);
      if (distance >= best) continue;
      best = distance;
      nearest = candidate;
    }
    std::swap(order[i + 1], *nearest);
  }
  return order;
}

std::vector<std::int32_t> curve_tour(const Distances& distances) {
  std::vector<Point> points;
  for (int i = 0; i < distances.count(); ++i) {
    points.push_back(distances.instance().points[static_cast<std::size_t>(distances.city(i))]);
  }
  const std::vector<int> order = PointGrid(points).along_curve();
  return {order.begin(), order.end()};
}

/// Cities instead of places, from place 0 on.
std::vector<int> cities_from_first(const Distances& distances,
                                   const std::vector<std::int32_t>& order) {
  std::vector<int> cities;
  const auto first = std::find(order.begin(), order.end(), 0);
  for (auto i = first; i != order.end(); ++i) cities.push_back(distances.city(*i));
  for (auto i = order.begin(); i != first; ++i) cities.push_back(distances.city(*i));
  return cities;
}

}  // namespace

std::vector<std::int32_t> first_tour(const Distances& distances) {
  const bool by_curve =
      distances.count() > kNearestUpTo && distances.instance().metric != Metric::kMatrix;
  return by_curve ? curve_tour(distances) : nearest_first_tour(distances);
}

std::vector<int> solve_tour(const Instance& instance,
                            bool symmetric,
                            const std::vector<int>& cities,
                            const TourSolverOptions& options) {
  if (cities.size() < 4 && (symmetric || cities.size() < 3)) return cities;
  const Distances distances(instance, cities, symmetric);
  const Neighbours near(distances, kNear);
  TourSearch search(distances, near, first_tour(distances));
  search.descend();
  const auto kicks = static_cast<std::int64_t>(options.kicks * static_cast<double>(cities.size()));
  if (kicks > 0) {
    Random random(cities.size());
    search.disturb(StopRule::after_iterations(kicks), random);
  }
  return cities_from_first(distances, search.order());
}

std::vector<int> solve_tour(const Instance& instance,
                            bool symmetric,
                            const std::vector<int>& cities,
                            const StopRule& stop,
                            Random& random) {
  if (cities.size() < 4 && (symmetric || cities.size() < 3)) return cities;
  const Distances distances(instance, cities, symmetric);
  const Neighbours near(distances, kNear);
  TourSearch search(distances, near, first_tour(distances));
  search.descend();
  search.disturb(stop, random);
  return cities_from_first(distances, search.order());
}

double tour_length(const Instance& instance, const std::vector<int>& cities) {
  double length = 0.0;
  for (std::size_t i = 0; i < cities.size(); ++i) {
    length += instance.distance(cities[i], cities[(i + 1) % cities.size()]);
  }
  return length;
}

}  // namespace imslam::routing

#include "slam/plugins/routing/tour_solver.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "slam/plugins/routing/point_grid.hpp"
#include "slam/plugins/routing/tour_search.hpp"

namespace imslam::routing {
namespace {

constexpr int kNear = 10;          ///< places that each is held against
constexpr int kNearestUpTo = 200;  ///< cities: more by the curve, if there are coordinates

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

namespace {

/// Sets the search up, has it descend from `start` and then `go_on`.
template <typename Start, typename GoOn>
std::vector<int> searched(const Instance& instance,
                          bool symmetric,
                          const std::vector<int>& cities,
                          const Start& start,
                          const GoOn& go_on) {
  if (cities.size() < 4 && (symmetric || cities.size() < 3)) return cities;
  const Distances distances(instance, cities, symmetric);
  const Neighbours near(distances, kNear);
  TourSearch search(distances, near, start(distances));
  search.descend();
  go_on(search);
  return cities_from_first(distances, search.order());
}

/// The kicks of a tour depend on its size only, so that equal cities give equal tours.
void kick(TourSearch& search, std::size_t cities, double kicks) {
  const auto count = static_cast<std::int64_t>(kicks * static_cast<double>(cities));
  if (count <= 0) return;
  Random random(cities);
  search.disturb(StopRule::after_iterations(count), random);
}

}  // namespace

std::vector<int> solve_tour(const Instance& instance,
                            bool symmetric,
                            const std::vector<int>& cities,
                            const TourSolverOptions& options) {
  return searched(instance, symmetric, cities, first_tour,
                  [&](TourSearch& search) { kick(search, cities.size(), options.kicks); });
}

std::vector<int> solve_tour(const Instance& instance,
                            bool symmetric,
                            const std::vector<int>& cities,
                            const StopRule& stop,
                            Random& random) {
  return searched(instance, symmetric, cities, first_tour,
                  [&](TourSearch& search) { search.disturb(stop, random); });
}

std::vector<int> polish_tour(const Instance& instance,
                             bool symmetric,
                             const std::vector<int>& tour,
                             double kicks) {
  const auto as_it_is = [](const Distances& distances) {
    std::vector<std::int32_t> order(static_cast<std::size_t>(distances.count()));
    std::iota(order.begin(), order.end(), 0);
    return order;
  };
  return searched(instance, symmetric, tour, as_it_is,
                  [&](TourSearch& search) { kick(search, tour.size(), kicks); });
}

double tour_length(const Instance& instance, const std::vector<int>& cities) {
  double length = 0.0;
  for (std::size_t i = 0; i < cities.size(); ++i) {
    length += instance.distance(cities[i], cities[(i + 1) % cities.size()]);
  }
  return length;
}

}  // namespace imslam::routing

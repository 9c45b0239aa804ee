#include "slam/plugins/routing/city_features.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace imslam::routing {
namespace {

constexpr int kWaves = 4;  ///< of the rank by direction

/// The box around all cities.
struct Field {
  Point middle;
  double extent = 1.0;
  double area = 0.0;
};

Field field_of(const std::vector<Point>& points) {
  Point low = points.front();
  Point high = low;
  for (const Point& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const double width = high.x - low.x;
  const double height = high.y - low.y;
  return {{0.5 * (low.x + high.x), 0.5 * (low.y + high.y)},
          std::max({width, height, 1e-300}),
          width * height};
}

/// From the depot to the mean of all cities; along x if that is where the depot is.
Point ahead_of(const std::vector<Point>& points, const Point& depot) {
  Point sum;
  for (const Point& p : points) sum = {sum.x + p.x - depot.x, sum.y + p.y - depot.y};
  const double length = std::hypot(sum.x, sum.y);
  return length > 0.0 ? Point{sum.x / length, sum.y / length} : Point{1.0, 0.0};
}

/// The places of the values in their order, from -1/2 to 1/2; equal values as they come.
std::vector<double> ranks_of(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    ranks[order[i]] = (static_cast<double>(i) + 0.5) / static_cast<double>(order.size()) - 0.5;
  }
  return ranks;
}

}  // namespace

nn::Tensor<float> city_features(const Instance& instance) {
  const std::size_t n = instance.points.size();
  const auto depot_index = static_cast<std::size_t>(instance.depot);
  const Field field = field_of(instance.points);
  const Point depot = instance.points[depot_index];
  const Point ahead = ahead_of(instance.points, depot);
  std::vector<double> along(n), across(n), away(n), angle(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = (instance.points[i].x - depot.x) / field.extent;
    const double dy = (instance.points[i].y - depot.y) / field.extent;
    along[i] = dx * ahead.x + dy * ahead.y;
    across[i] = dy * ahead.x - dx * ahead.y;
    away[i] = std::hypot(dx, dy);
    angle[i] = away[i] > 0.0 ? std::atan2(across[i], along[i]) : 0.0;
  }
  const std::vector<double> direction = ranks_of(angle);
  const std::vector<double> distance = ranks_of(away);
  // Shortest tours of n uniform cities in an area A are about 0.7124 sqrt(n A) long.
  const double tour = 0.7124 * std::sqrt(static_cast<double>(n) * field.area) / field.extent;
  const double work = std::log(1.0 + tour) - 2.0;
  nn::Tensor<float> features({static_cast<nn::Index>(n), kCityFeatures});
  nn::Index next = 0;
  const auto fill = [&](std::size_t i) {
    const auto put = [&](double value) { features[next++] = static_cast<float>(value); };
    const double unit = std::max(away[i], 1e-6);
    put((instance.points[i].x - field.middle.x) / field.extent);
    put((instance.points[i].y - field.middle.y) / field.extent);
    for (const double value : {along[i], across[i], away[i]}) put(value);
    for (const double value : {along[i] / unit, across[i] / unit}) put(value);
    for (const double value : {direction[i], distance[i]}) put(value);
    for (int k = 1; k <= kWaves; ++k) put(std::cos(M_PI * k * (direction[i] + 0.5)));
    for (const double value : {work, i == depot_index ? 1.0 : 0.0}) put(value);
  };
  fill(depot_index);
  for (std::size_t i = 0; i < n; ++i) {
    if (i != depot_index) fill(i);
  }
  return features;
}

}  // namespace imslam::routing

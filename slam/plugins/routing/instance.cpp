#include "slam/plugins/routing/instance.hpp"

#include <fmt/format.h>

#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::routing {
namespace {

/// TSPLIB counts minutes as hundredths, cuts pi short and takes the Earth as a ball.
double geographic_distance(const Point& a, const Point& b) {
  constexpr double kPi = 3.141592;
  constexpr double kEarthRadius_km = 6378.388;
  const auto radians = [&](double degrees_minutes) {
    const double degrees = std::trunc(degrees_minutes);
    return kPi * (degrees + 5.0 * (degrees_minutes - degrees) / 3.0) / 180.0;
  };
  const double q1 = std::cos(radians(a.y) - radians(b.y));
  const double q2 = std::cos(radians(a.x) - radians(b.x));
  const double q3 = std::cos(radians(a.x) + radians(b.x));
  return std::floor(kEarthRadius_km * std::acos(0.5 * ((1.0 + q1) * q2 - (1.0 - q1) * q3)) + 1.0);
}

double pseudo_euclidean_distance(double length) {
  const double scaled = length / std::sqrt(10.0);
  const double rounded = std::floor(scaled + 0.5);
  return rounded < scaled ? rounded + 1.0 : rounded;
}

}  // namespace

int Instance::city_count() const {
  if (metric != Metric::kMatrix) return static_cast<int>(points.size());
  return static_cast<int>(std::lround(std::sqrt(static_cast<double>(matrix.size()))));
}

double Instance::distance(int from, int to) const {
  if (from == to) return 0.0;
  const auto a = static_cast<std::size_t>(from);
  const auto b = static_cast<std::size_t>(to);
  if (metric == Metric::kMatrix) return matrix[a * static_cast<std::size_t>(city_count()) + b];
  if (metric == Metric::kGeographic) return geographic_distance(points[a], points[b]);
  const double dx = points[a].x - points[b].x;
  const double dy = points[a].y - points[b].y;
  const double length = std::sqrt(dx * dx + dy * dy);
  if (metric == Metric::kEuclidean) return length;
  if (metric == Metric::kEuclideanRounded) return std::floor(length + 0.5);
  if (metric == Metric::kEuclideanCeiled) return std::ceil(length);
  return pseudo_euclidean_distance(length);
}

bool Instance::symmetric() const {
  if (metric != Metric::kMatrix) return true;
  const int n = city_count();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      if (distance(i, j) != distance(j, i)) return false;
    }
  }
  return true;
}

Instance random_instance(int cities, Random& random) {
  if (cities < 2) {
    throw InputError(fmt::format("{} cities: expected 2 or more, one of them is the depot", cities),
                     ExitCode::kUsage);
  }
  Instance instance;
  instance.name = fmt::format("random{}", cities);
  for (int i = 0; i < cities; ++i) {
    const double x = random.uniform();
    instance.points.push_back({x, random.uniform()});
  }
  return instance;
}

}  // namespace imslam::routing

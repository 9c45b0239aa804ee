#include "slam/plugins/routing/surrogate_features.hpp"

#include <algorithm>
#include <cmath>

#include "slam/plugins/routing/allocation_surrogate.hpp"

namespace imslam::routing {
namespace {

using learner::Matrix;
using learner::Vector;

/// What one agent expects to visit.
struct Expectation {
  double load = 0.0;  ///< cities
  Point centre;
  double spread = 0.0;  ///< standard deviation about the centre
  double tour = 0.0;    ///< there and back, and through that many cities of such a field
};

/// Shortest tours of n uniform cities in an area A are about 0.7124 sqrt(n A) long, and a uniform
/// square has A = 6 spread^2.
double expected_tour(const Expectation& e, const Point& depot) {
  const double way = std::hypot(e.centre.x - depot.x, e.centre.y - depot.y);
  return 2.0 * way + 0.7124 * std::sqrt(6.0 * e.load) * e.spread;
}

Matrix positions_of(const Instance& instance) {
  Matrix positions(instance.city_count() - 1, 2);
  Eigen::Index row = 0;
  for (int city = 0; city < instance.city_count(); ++city) {
    if (city == instance.depot) continue;
    const Point& p = instance.points[static_cast<std::size_t>(city)];
    positions.row(row++) << p.x, p.y;
  }
  return positions;
}

Expectation expectation(const Matrix& positions, const Vector& p, const Point& depot) {
  Expectation e;
  e.load = p.sum();
  const double weight = std::max(e.load, 1e-9);
  const Eigen::RowVector2d centre = p.transpose() * positions / weight;
  e.centre = {centre.x(), centre.y()};
  const Vector squares = (positions.rowwise() - centre).rowwise().squaredNorm();
  e.spread = std::sqrt(p.dot(squares) / weight);
  e.tour = expected_tour(e, depot);
  return e;
}

}  // namespace

SurrogateFeatures surrogate_features(const Instance& instance, const Matrix& probabilities) {
  const Eigen::Index cities = probabilities.rows();
  const Eigen::Index agents = probabilities.cols();
  const Matrix positions = positions_of(instance);
  const Point depot = instance.points[static_cast<std::size_t>(instance.depot)];
  std::vector<Expectation> all;
  double longest = 0.0;
  double mean = 0.0;
  for (Eigen::Index j = 0; j < agents; ++j) {
    all.push_back(expectation(positions, probabilities.col(j), depot));
    longest = std::max(longest, all.back().tour);
    mean += all.back().tour / static_cast<double>(agents);
  }
  constexpr int kPair = SurrogateNetwork<float>::kPairFeatures;
  SurrogateFeatures features{nn::Tensor<float>({cities * agents, kPair}),
                             nn::Tensor<float>({1, SurrogateNetwork<float>::kWholeFeatures})};
  double entropy = 0.0;
  for (Eigen::Index i = 0; i < cities; ++i) {
    const double away = std::hypot(positions(i, 0) - depot.x, positions(i, 1) - depot.y);
    for (Eigen::Index j = 0; j < agents; ++j) {
      const Expectation& e = all[static_cast<std::size_t>(j)];
      const double off = std::hypot(positions(i, 0) - e.centre.x, positions(i, 1) - e.centre.y);
      const double p = probabilities(i, j);
      entropy -= p * std::log(std::max(p, 1e-12)) / static_cast<double>(cities);
      const double values[kPair] = {
          p,    off,    e.spread,        e.load * double(agents) / double(cities),
          away, e.tour, e.tour - longest};
      for (int k = 0; k < kPair; ++k) {
        features.pairs[(i * agents + j) * kPair + k] = static_cast<float>(values[k]);
      }
    }
  }
  const double whole[] = {longest, mean, longest - mean, entropy, std::sqrt(double(cities)) / 10.0};
  for (std::size_t k = 0; k < std::size(whole); ++k) {
    features.whole[static_cast<nn::Index>(k)] = static_cast<float>(whole[k]);
  }
  return features;
}

}  // namespace imslam::routing

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "slam/base/random.hpp"

namespace imslam::routing {

/// How far it is from city to city. All but the first and last are those of TSPLIB (Reinelt 1991),
/// which round to whole numbers.
enum class Metric {
  kEuclidean,
  kEuclideanRounded,  ///< EUC_2D
  kEuclideanCeiled,   ///< CEIL_2D
  kGeographic,        ///< GEO: latitude, longitude as DDD.MM; [km]
  kPseudoEuclidean,   ///< ATT
  kMatrix,            ///< as the table says: need be neither symmetric nor a metric
};

struct Point {
  double x = 0.0;
  double y = 0.0;
};

/// Cities 0 ... n - 1, one of which is the depot where every tour starts and ends.
struct Instance {
  std::string name;
  Metric metric = Metric::kEuclidean;
  std::vector<Point> points;   ///< n; empty if there is only a table
  std::vector<double> matrix;  ///< kMatrix: n x n, row: from, column: to; else empty
  int depot = 0;

  int city_count() const;
  /// Exactly; 0 from a city to itself.
  double distance(int from, int to) const;
  bool symmetric() const;  ///< looks at all of a table
};

/// Uniform in the unit square; the depot is city 0, as random as the others. Throws
/// InputError(kUsage) on less than 2 cities.
Instance random_instance(int cities, Random& random);

}  // namespace imslam::routing

#pragma once

#include <vector>

#include "slam/plugins/routing/instance.hpp"

namespace imslam::routing {

/// Points sorted into square cells, about two in each.
class PointGrid {
 public:
  explicit PointGrid(const std::vector<Point>& points);

  /// All points of the smallest square of cells about `point` that holds at least `count`, and of
  /// one more ring, for those that are nearer than the square's corners.
  std::vector<int> around(const Point& point, int count) const;

  /// The points cell by cell along a Hilbert curve: a tour that keeps neighbours together.
  std::vector<int> along_curve() const;

 private:
  int column(double x) const;
  int row(double y) const;
  void collect(int x, int y, std::vector<int>& found) const;
  void collect_ring(int x, int y, int radius, std::vector<int>& found) const;

  Point low_;
  double cell_ = 1.0;
  int side_ = 1;                         ///< cells, a power of two
  std::vector<std::vector<int>> cells_;  ///< row by row
};

}  // namespace imslam::routing

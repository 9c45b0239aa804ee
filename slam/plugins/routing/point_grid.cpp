#include "slam/plugins/routing/point_grid.hpp"

#include <algorithm>
#include <cmath>

namespace imslam::routing {
namespace {

struct Cell {
  int x = 0;
  int y = 0;
};

/// Cell number `step` of the Hilbert curve through side x side cells.
Cell hilbert_cell(int side, int step) {
  Cell cell;
  for (int size = 1; size < side; size *= 2, step /= 4) {
    const int right = 1 & (step / 2);
    const int up = 1 & (step ^ right);
    if (up == 0) {
      if (right == 1) cell = {size - 1 - cell.x, size - 1 - cell.y};
      std::swap(cell.x, cell.y);
    }
    cell.x += size * right;
    cell.y += size * up;
  }
  return cell;
}

}  // namespace

PointGrid::PointGrid(const std::vector<Point>& points) {
  if (points.empty()) return;
  low_ = points.front();
  Point high = low_;
  for (const Point& p : points) {
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  while (side_ < 1024 && 2 * side_ * side_ < static_cast<int>(points.size())) side_ *= 2;
  const double extent = std::max({high.x - low_.x, high.y - low_.y, 1e-300});
  cell_ = extent / side_;
  cells_.resize(static_cast<std::size_t>(side_ * side_));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int cell = row(points[i].y) * side_ + column(points[i].x);
    cells_[static_cast<std::size_t>(cell)].push_back(static_cast<int>(i));
  }
}

int PointGrid::column(double x) const {
  return std::clamp(static_cast<int>((x - low_.x) / cell_), 0, side_ - 1);
}
int PointGrid::row(double y) const {
  return std::clamp(static_cast<int>((y - low_.y) / cell_), 0, side_ - 1);
}

void PointGrid::collect(int x, int y, std::vector<int>& found) const {
  if (x < 0 || y < 0 || x >= side_ || y >= side_) return;
  const std::vector<int>& cell = cells_[static_cast<std::size_t>(y * side_ + x)];
  found.insert(found.end(), cell.begin(), cell.end());
}

void PointGrid::collect_ring(int x, int y, int radius, std::vector<int>& found) const {
  if (radius == 0) return collect(x, y, found);
  for (int k = -radius; k <= radius; ++k) {
    collect(x + k, y - radius, found);
    collect(x + k, y + radius, found);
    if (std::abs(k) == radius) continue;
    collect(x - radius, y + k, found);
    collect(x + radius, y + k, found);
  }
}

std::vector<int> PointGrid::around(const Point& point, int count) const {
  std::vector<int> found;
  const int x = column(point.x);
  const int y = row(point.y);
  int radius = 0;
  while (radius <= side_ && static_cast<int>(found.size()) < count) {
    collect_ring(x, y, radius++, found);
  }
  // A circle about the point that holds as many reaches sqrt(2) times as far as the square.
  const int further = std::min(side_, static_cast<int>(std::ceil(1.42 * radius)));
  while (radius <= further) collect_ring(x, y, radius++, found);
  return found;
}

std::vector<int> PointGrid::along_curve() const {
  std::vector<int> order;
  for (int step = 0; step < side_ * side_; ++step) {
    const Cell cell = hilbert_cell(side_, step);
    collect(cell.x, cell.y, order);
  }
  return order;
}

}  // namespace imslam::routing

#include "vo_net/corner_detector.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace imslam::vo {
namespace {

struct Grid {
  Grid(int width, int height, double side_in)
      : side(side_in),
        columns(static_cast<int>(std::ceil(width / side_in))),
        rows(static_cast<int>(std::ceil(height / side_in))) {}

  std::size_t cell_of(double x, double y) const {
    const int c = std::clamp(static_cast<int>(x / side), 0, columns - 1);
    const int r = std::clamp(static_cast<int>(y / side), 0, rows - 1);
    return static_cast<std::size_t>(r * columns + c);
  }
  std::size_t cells() const { return static_cast<std::size_t>(rows * columns); }
  Eigen::Vector2d centre(std::size_t cell) const {
    const auto index = static_cast<int>(cell);
    return side * Eigen::Vector2d(index % columns + 0.5, index / columns + 0.5);
  }

  double side;
  int columns;
  int rows;
};

}  // namespace

double cell_side(int width, int height, int max_points) {
  return std::max(2.0, std::sqrt(static_cast<double>(width) * height / max_points));
}

std::vector<Eigen::Vector2d> detect_corners(const ImagePyramid& image,
                                            const std::vector<Eigen::Vector2d>& taken,
                                            const CornerOptions& options) {
  const ImagePyramid::Level& full = image[0];
  const int level = image.levels().size() > 1 ? 1 : 0;
  const ImagePyramid::Level& searched = image[level];
  const double scale = level == 1 ? 2.0 : 1.0;
  const Grid grid(full.width, full.height, cell_side(full.width, full.height, options.max_points));

  std::vector<char> is_taken(grid.cells(), 0);
  for (const Eigen::Vector2d& p : taken) is_taken[grid.cell_of(p.x(), p.y())] = 1;

  const cv::Mat pixels(searched.height, searched.width, CV_32F, const_cast<float*>(searched.pixels),
                       static_cast<std::size_t>(searched.stride) * sizeof(float));
  cv::Mat quality;
  // Sobel sums 8 differences over 2 px, the box is a mean: this makes it [grey^2/px^2].
  cv::cornerMinEigenVal(pixels, quality, options.block, 3, cv::BORDER_REFLECT_101);

  std::vector<float> best(grid.cells(), static_cast<float>(options.min_quality));
  std::vector<Eigen::Vector2d> where(grid.cells(), Eigen::Vector2d::Constant(-1.0));
  const int margin = static_cast<int>(std::ceil(options.margin / scale));
  for (int y = margin; y < searched.height - margin; ++y) {
    const float* row = quality.ptr<float>(y);
    for (int x = margin; x < searched.width - margin; ++x) {
      const std::size_t cell = grid.cell_of(x * scale, y * scale);
      if (row[x] <= best[cell] || is_taken[cell] != 0) continue;
      best[cell] = row[x];
      where[cell] = Eigen::Vector2d(x * scale, y * scale);
    }
  }
  std::vector<Eigen::Vector2d> corners;
  const Eigen::AlignedBox2d allowed(
      Eigen::Vector2d::Constant(options.margin),
      Eigen::Vector2d(full.width - 1 - options.margin, full.height - 1 - options.margin));
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    if (where[cell].x() >= 0.0) corners.push_back(where[cell]);
    if (where[cell].x() >= 0.0 || !options.fill_cells || is_taken[cell] != 0) continue;
    if (allowed.contains(grid.centre(cell))) corners.push_back(grid.centre(cell));
  }
  return corners;
}

}  // namespace imslam::vo

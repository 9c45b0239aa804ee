#include "vo_net/flow_grid.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "slam/base/error.hpp"

namespace imslam::vo {
namespace {

using nn::Index;

constexpr Index kCells = FlowGrid::kRows * FlowGrid::kColumns;

/// Weighted sums over the points of one cell.
struct Cell {
  double weight = 0.0;
  Eigen::Vector2d flow = Eigen::Vector2d::Zero();
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
};

bool usable(const Correspondence& c, const StereoCamera& camera) {
  const double farthest = camera.width + camera.height;  // beyond it nothing is seen
  return c.left0.allFinite() && (c.left1 - c.left0).norm() < farthest && std::isfinite(c.weight) &&
         c.weight > 0.0 && c.left0.x() >= -0.5 && c.left0.x() < camera.width - 0.5 &&
         c.left0.y() >= -0.5 && c.left0.y() < camera.height - 0.5;
}

Index cell_of(const Eigen::Vector2d& pixel, const StereoCamera& camera) {
  const auto part = [](double x, int size, Index cells) {
    const auto i = static_cast<Index>((x + 0.5) / size * static_cast<double>(cells));
    return std::clamp<Index>(i, 0, cells - 1);
  };
  return part(pixel.y(), camera.height, FlowGrid::kRows) * FlowGrid::kColumns +
         part(pixel.x(), camera.width, FlowGrid::kColumns);
}

Eigen::Vector2d centre_of(Index cell, const StereoCamera& camera) {
  const auto row = static_cast<double>(cell / FlowGrid::kColumns);
  const auto column = static_cast<double>(cell % FlowGrid::kColumns);
  const double u = (column + 0.5) * camera.width / static_cast<double>(FlowGrid::kColumns) - 0.5;
  const double v = (row + 0.5) * camera.height / static_cast<double>(FlowGrid::kRows) - 0.5;
  return {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy};
}

}  // namespace

void FlowGrid::fill(const Correspondences& correspondences,
                    const StereoCamera& camera,
                    Index sample,
                    nn::Tensor<float>& grids) {
  const nn::Shape shape = grids.shape();
  nn::expects_shape(shape.rank() == 4 && shape[1] == kRows && shape[2] == kColumns &&
                        shape[3] == kChannels && sample >= 0 && sample < shape[0],
                    "FlowGrid::fill: grids from FlowGrid::make", shape);
  std::vector<Cell> cells(static_cast<std::size_t>(kCells));
  for (const Correspondence& c : correspondences) {
    if (!usable(c, camera)) continue;
    Cell& cell = cells[static_cast<std::size_t>(cell_of(c.left0, camera))];
    const Eigen::Vector2d moved = c.left1 - c.left0;
    cell.weight += c.weight;
    cell.flow += c.weight * Eigen::Vector2d(moved.x() / camera.fx, moved.y() / camera.fy);
    cell.place += c.weight * Eigen::Vector2d((c.left0.x() - camera.cx) / camera.fx,
                                             (c.left0.y() - camera.cy) / camera.fy);
  }
  float* out = grids.data() + sample * kCells * kChannels;
  for (Index i = 0; i < kCells; ++i, out += kChannels) {
    const Cell& cell = cells[static_cast<std::size_t>(i)];
    const bool seen = cell.weight > 0.0;
    const double share = seen ? 1.0 / cell.weight : 0.0;
    const Eigen::Vector2d flow = share * cell.flow;
    const Eigen::Vector2d place = seen ? (share * cell.place).eval() : centre_of(i, camera);
    out[kFlowX] = static_cast<float>(flow.x());
    out[kFlowY] = static_cast<float>(flow.y());
    out[kConfidence] = static_cast<float>(std::min(1.0, cell.weight));
    out[kPlaceX] = static_cast<float>(place.x());
    out[kPlaceY] = static_cast<float>(place.y());
  }
}

}  // namespace imslam::vo

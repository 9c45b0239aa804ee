#include "slam/system/map_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace imslam::system {

MapSampler::MapSampler(const StereoCamera& camera, const SystemOptions& options)
    : camera_(camera),
      points_per_frame_(static_cast<std::size_t>(options.map_points_per_frame)),
      min_disparity_px_(camera.fx / options.map_max_depth_baselines) {}

void MapSampler::add(const StereoFrame& frame,
                     std::uint32_t index,
                     const vo::VoOutput& seen,
                     MapBuilder& map) const {
  if (!seen.motion.valid || !frame.complete()) return;
  // Only points that agreed with the motion: the end of each inlier correspondence.
  std::vector<const vo::Correspondence*> good;
  for (std::size_t i = 0; i < seen.correspondences.size(); ++i) {
    const auto& correspondence = seen.correspondences[i];
    const bool inlier = i < seen.pose.is_inlier.size() && seen.pose.is_inlier[i] != 0;
    const bool near = correspondence.disparity1 > min_disparity_px_;
    if (inlier && near && correspondence.disparity1_information > 0.0)
      good.push_back(&correspondence);
  }
  const std::size_t count = std::min(points_per_frame_, good.size());
  for (std::size_t k = 0; k < count; ++k) {
    const auto& point = *good[k * good.size() / count];  // evenly over the list: over the image
    const auto column = static_cast<int>(std::lround(point.left1.x()));
    const auto row = static_cast<int>(std::lround(point.left1.y()));
    if (column < 0 || row < 0 || column >= frame.left.width || row >= frame.left.height) continue;
    const Eigen::Vector3d p_left =
        camera_.back_project({point.left1.x(), point.left1.y(), point.disparity1});
    map.add({p_left.cast<float>(), index, frame.left.at(row, column)});
  }
}

}  // namespace imslam::system

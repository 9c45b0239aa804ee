#include "datasets/simulation/truth.hpp"

#include <cmath>

#include "slam/base/parallel.hpp"

namespace imslam::simulation {

std::vector<float> depth_of(const View& view, const RayTable& rays) {
  std::vector<float> depth(view.distance.size(), 0.0F);
  parallel_for(static_cast<std::size_t>(view.height), [&](std::size_t at_row) {
    const int row = static_cast<int>(at_row);
    for (int column = 0; column < view.width; ++column) {
      const std::size_t at = view.index(row, column);
      if (std::isfinite(view.distance[at])) {
        depth[at] = view.distance[at] * static_cast<float>(rays.direction(row, column).z());
      }
    }
  });
  return depth;
}

Flow flow_of(const View& view,
             const World& world,
             const RayTable& rays,
             const Lens& lens,
             const lie::SE3d& T_world_camera0,
             const lie::SE3d& T_world_camera1,
             double t0,
             double t1) {
  // One rigid motion camera0 -> camera1 for each instance; the fixed world is instance 0.
  std::vector<Eigen::Matrix4d> motions;
  for (std::uint32_t i = 0; i <= world.scene().instances.size(); ++i) {
    const lie::SE3d T_camera1_camera0 =
        T_world_camera1.inverse() * world.instance_motion(i, t0, t1) * T_world_camera0;
    motions.push_back(T_camera1_camera0.matrix());
  }
  Flow flow;
  flow.displacement.resize(2 * view.distance.size(), 0.0F);
  flow.valid.resize(view.distance.size(), 0);
  parallel_for(static_cast<std::size_t>(view.height), [&](std::size_t at_row) {
    const int row = static_cast<int>(at_row);
    for (int column = 0; column < view.width; ++column) {
      const std::size_t at = view.index(row, column);
      const Eigen::Vector2d pixel0(column, row);
      const Eigen::Matrix4d& T = motions[view.instance[at]];
      // The sky is infinitely far: only the rotation moves it.
      Eigen::Vector3d p = T.topLeftCorner<3, 3>() * rays.direction(row, column);
      if (std::isfinite(view.distance[at])) {
        p = static_cast<double>(view.distance[at]) * p + T.topRightCorner<3, 1>();
      }
      const auto pixel1 = lens.project(p);
      if (!pixel1) continue;
      const Eigen::Vector2f change = (*pixel1 - pixel0).cast<float>();
      flow.displacement[2 * at] = change.x();
      flow.displacement[2 * at + 1] = change.y();
      flow.valid[at] = lens.contains(*pixel1) ? 1 : 0;
    }
  });
  return flow;
}

}  // namespace imslam::simulation

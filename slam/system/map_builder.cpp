#include "slam/system/map_builder.hpp"

#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include "slam/base/error.hpp"

namespace imslam::system {

using Cloud = pcl::PointCloud<pcl::PointXYZI>;

namespace {

/// Where a point lies with its true disparity; along the same ray.
Eigen::Vector3d corrected(const MapPoint& point, const MapCamera& camera) {
  const Eigen::Vector3d p_left = point.p_left.cast<double>();
  if (camera.disparity_offset_px == 0.0) return p_left;
  const double disparity = camera.focal_baseline / p_left.z();
  return p_left * (disparity / (disparity - camera.disparity_offset_px));
}

Cloud::Ptr to_world(const std::vector<MapPoint>& points,
                    const Trajectory& trajectory,
                    const MapCamera& camera) {
  auto cloud = pcl::make_shared<Cloud>();
  for (const MapPoint& point : points) {
    if (point.frame >= trajectory.size()) continue;
    const Eigen::Vector3d p_world =
        trajectory.poses[point.frame] * (camera.T_body_left * corrected(point, camera));
    if (!p_world.allFinite()) continue;
    pcl::PointXYZI out;
    out.getVector3fMap() = p_world.cast<float>();
    out.intensity = static_cast<float>(point.gray);
    cloud->push_back(out);
  }
  return cloud;
}

/// PCL's voxel grid counts its cells in 32 bits: a map of kilometres needs larger cubes.
float cube_side(const Cloud& cloud, double voxel_m) {
  Eigen::Array3f low = Eigen::Array3f::Zero();
  Eigen::Array3f high = Eigen::Array3f::Zero();
  for (const auto& point : cloud) {
    low = low.min(point.getArray3fMap());
    high = high.max(point.getArray3fMap());
  }
  constexpr double kMaximumCells = 2.0e9;
  double side = voxel_m;
  const Eigen::Array3d extent = (high - low).cast<double>();
  while (((extent / side) + 1.0).floor().prod() > kMaximumCells) side *= 1.25;
  return static_cast<float>(side);
}

}  // namespace

void MapBuilder::write_pcd(const std::filesystem::path& file,
                           const Trajectory& trajectory,
                           const MapCamera& camera,
                           double voxel_m) const {
  const Cloud::Ptr cloud = to_world(points_, trajectory, camera);
  Cloud filtered;
  if (!cloud->empty()) {
    const float side = cube_side(*cloud, voxel_m);
    pcl::VoxelGrid<pcl::PointXYZI> grid;
    grid.setInputCloud(cloud);
    grid.setLeafSize(side, side, side);
    grid.filter(filtered);
  }
  if (filtered.empty()) filtered.push_back(pcl::PointXYZI());  // PCL refuses to write empty clouds
  try {
    pcl::io::savePCDFileBinary(file.string(), filtered);
  } catch (const pcl::PCLException& error) {
    throw InputError(file.string() + ": " + error.what() + "; check free space and permissions",
                     ExitCode::kOutput);
  }
}

}  // namespace imslam::system

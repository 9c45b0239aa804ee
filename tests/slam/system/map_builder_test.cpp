#include "slam/system/map_builder.hpp"

#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include "slam/base/error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam::system {
namespace {

Trajectory two_poses() {
  Trajectory trajectory;
  trajectory.add(0, lie::SE3d());
  trajectory.add(1, lie::SE3d(lie::SO3d(), {10.0, 0.0, 0.0}));
  return trajectory;
}

TEST(MapBuilder, PutsPointsIntoTheWorldAndMergesNeighbours) {
  MapBuilder map;
  map.add({{1.01F, 2.01F, 3.01F}, 0, 100});
  map.add({{1.02F, 2.02F, 3.02F}, 0, 200});
  map.add({{1.01F, 2.01F, 3.01F}, 1, 50});
  map.add({{0.0F, 0.0F, 0.0F}, 7, 50});  // a frame that has no pose
  const testing::TempDir dir;
  map.write_pcd(dir.path() / "map.pcd", two_poses(), {}, 0.1);

  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((dir.path() / "map.pcd").string(), cloud), 0);
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_NEAR(cloud[0].x, 1.015F, 1e-4F);
  EXPECT_NEAR(cloud[0].intensity, 150.0F, 1e-3F);
  EXPECT_NEAR(cloud[1].x, 11.01F, 1e-4F);
}

TEST(MapBuilder, KnowsTheFrameOfEachPointHoweverTheyCome) {
  MapBuilder map;
  for (const std::uint32_t frame : {1U, 0U, 9U, 1U, 1U}) map.add({{1.0F, 0.0F, 0.0F}, frame, 7});
  EXPECT_EQ(map.size(), 5U);
  const testing::TempDir dir;
  map.write_pcd(dir.path() / "map.pcd", two_poses(), {}, 0.1);
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((dir.path() / "map.pcd").string(), cloud), 0);
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_NEAR(cloud[0].x, 1.0F, 1e-4F);
  EXPECT_NEAR(cloud[1].x, 11.0F, 1e-4F);
}

TEST(MapBuilder, LooksThroughTheCameraWhereItSitsOnTheBody) {
  MapBuilder map;
  map.add({{0.0F, 0.0F, 2.0F}, 1, 7});  // 2 m ahead of a camera that looks along the body's x
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const auto R_body_left = lie::SO3d::from_matrix(R);
  const testing::TempDir dir;
  map.write_pcd(dir.path() / "map.pcd", two_poses(), {lie::SE3d(R_body_left, {0.0, 0.3, 0.1})},
                0.1);
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((dir.path() / "map.pcd").string(), cloud), 0);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_NEAR(cloud[0].x, 12.0F, 1e-5F);
  EXPECT_NEAR(cloud[0].y, 0.3F, 1e-5F);
  EXPECT_NEAR(cloud[0].z, 0.1F, 1e-5F);
}

TEST(MapBuilder, DisparitiesLoseTheirOffset) {
  MapBuilder map;
  map.add({{0.4F, 0.2F, 2.0F}, 0, 7});  // 20 px, of which 4 are wrong
  const testing::TempDir dir;
  map.write_pcd(dir.path() / "map.pcd", two_poses(), {{}, 40.0, 4.0}, 0.1);
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((dir.path() / "map.pcd").string(), cloud), 0);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_NEAR(cloud[0].x, 0.5F, 1e-5F);
  EXPECT_NEAR(cloud[0].y, 0.25F, 1e-5F);
  EXPECT_NEAR(cloud[0].z, 2.5F, 1e-5F);
}

TEST(MapBuilder, AFolderThatIsNotThereIsAnOutputError) {
  const testing::TempDir dir;
  try {
    MapBuilder().write_pcd(dir.path() / "none" / "map.pcd", two_poses(), {}, 0.1);
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kOutput);
  }
}

}  // namespace
}  // namespace imslam::system

#include "vo_net/visual_odometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "slam/base/error.hpp"
#include "tests/support/test_data.hpp"
#include "tests/vo_net/synthetic_images.hpp"

namespace imslam::vo {
namespace {

using testing::PlaneWorld;
using testing::pose_of_frame;
using testing::small_camera;
using testing::time_of_frame;
using testing::uniform_image;

VoOptions small_options() {
  VoOptions options;
  options.klt.max_points = 250;
  return options;
}

/// T_body0_body1 between two frames of the synthetic drive.
lie::SE3d true_motion(const StereoCamera& camera, int frame0, int frame1) {
  const lie::SE3d& T_body_left = camera.T_body_left;
  return T_body_left * pose_of_frame(frame0).inverse() * pose_of_frame(frame1) *
         T_body_left.inverse();
}

void expect_motion(const RelativeMotion& motion,
                   const lie::SE3d& truth,
                   double metres,
                   double radians) {
  ASSERT_TRUE(motion.valid);
  const auto e = (motion.T_body0_body1.inverse() * truth).log();
  EXPECT_LT(e.head<3>().norm(), metres);
  EXPECT_LT(e.tail<3>().norm(), radians);
}

TEST(VisualOdometry, RecoversTheMotionThroughAPlaneWorld) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(11);
  VisualOdometry odometry(small_options(), camera);
  for (int i = 0; i < 6; ++i) {
    const VoOutput output =
        odometry.process(world.draw(camera, pose_of_frame(i), time_of_frame(i)));
    if (i == 0) {
      EXPECT_FALSE(output.motion.valid);
      EXPECT_GT(output.points.size(), 100U);
      continue;
    }
    EXPECT_EQ(output.motion.time0_ns, time_of_frame(i - 1));
    EXPECT_EQ(output.motion.time1_ns, time_of_frame(i));
    expect_motion(output.motion, true_motion(camera, i - 1, i), 1e-3, 3e-4);
  }
}

TEST(VisualOdometry, BridgesFramesWithoutAnImage) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(12);
  VisualOdometry odometry(small_options(), camera);
  for (int i = 0; i < 5; ++i) {
    StereoFrame frame = world.draw(camera, pose_of_frame(i), time_of_frame(i));
    if (i == 2) frame.right = GrayImage();
    if (i == 3) frame.left = frame.right = GrayImage();
    const VoOutput output = odometry.process(frame);
    if (i == 2 || i == 3) {
      EXPECT_FALSE(output.motion.valid);
      EXPECT_EQ(odometry.anchor_time_ns(), time_of_frame(1));
    }
    if (i == 4) {
      EXPECT_EQ(output.motion.time0_ns, time_of_frame(1));
      EXPECT_EQ(output.motion.time1_ns, time_of_frame(4));
      expect_motion(output.motion, true_motion(camera, 1, 4), 2e-3, 5e-4);
    }
  }
}

class BadImages : public ::testing::TestWithParam<std::string> {};

TEST_P(BadImages, AreLeftOutAndBridged) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(13);
  Random random(13);
  VisualOdometry odometry(small_options(), camera);
  for (int i = 0; i < 8; ++i) {
    StereoFrame frame = world.draw(camera, pose_of_frame(i), time_of_frame(i));
    const bool bad = i >= 2 && i <= 4;
    if (bad && GetParam() == "black") frame.left = frame.right = uniform_image(camera, 3);
    if (bad && GetParam() == "white") frame.left = frame.right = uniform_image(camera, 255);
    if (bad && GetParam() == "noise") {
      frame.left = testing::noise_image(camera, random);
      frame.right = testing::noise_image(camera, random);
    }
    const VoOutput output = odometry.process(frame);
    EXPECT_TRUE(output.motion.covariance.allFinite());
    EXPECT_TRUE(output.motion.T_body0_body1.matrix().allFinite());
    if (bad) {
      EXPECT_FALSE(output.motion.valid);
    } else if (i >= 1) {
      EXPECT_EQ(output.motion.time0_ns, time_of_frame(i == 5 ? 1 : i - 1));
      expect_motion(output.motion, true_motion(camera, i == 5 ? 1 : i - 1, i), 2e-3, 5e-4);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, BadImages, ::testing::Values("black", "white", "noise"));

TEST(VisualOdometry, StartsAnewAfterACut) {
  const StereoCamera camera = small_camera();
  const PlaneWorld before(17);
  const PlaneWorld after(18);
  VisualOdometry odometry(small_options(), camera);
  for (int i = 0; i < 6; ++i) {
    const PlaneWorld& world = i < 3 ? before : after;
    const VoOutput output =
        odometry.process(world.draw(camera, pose_of_frame(i), time_of_frame(i)));
    if (i == 3) {
      EXPECT_FALSE(output.motion.valid);
      EXPECT_EQ(odometry.anchor_time_ns(), time_of_frame(3));
    }
    if (i > 3) expect_motion(output.motion, true_motion(camera, i - 1, i), 1e-3, 3e-4);
  }
}

TEST(VisualOdometry, IsNotLostForeverAfterACutToAnEmptierScene) {
  const StereoCamera camera = small_camera();
  const PlaneWorld before(17);
  const PlaneWorld after(18);
  VoOptions options = small_options();
  options.klt.window = 15;  // large, so that few corners fit into the strip
  options.klt.stereo_window = 15;
  VisualOdometry odometry(options, camera);
  for (int i = 0; i < 12; ++i) {
    const bool cut = i >= 3;
    StereoFrame frame = (cut ? after : before).draw(camera, pose_of_frame(i), time_of_frame(i));
    const auto most = static_cast<std::ptrdiff_t>(frame.left.pixels.size() * 6 / 7);
    for (GrayImage* image : {&frame.left, &frame.right}) {
      if (cut) std::fill(image->pixels.begin(), image->pixels.begin() + most, std::uint8_t{128});
    }
    const VoOutput output = odometry.process(frame);
    if (cut) {
      EXPECT_LT(output.points.size(), 75U);
    }
    if (i == 11) {  // a strip of a plane says little about the motion, but it says something again
      EXPECT_TRUE(output.motion.valid);
      EXPECT_EQ(output.motion.time0_ns, time_of_frame(10));
    }
  }
}

TEST(VisualOdometry, WaitsForTheFirstGoodFrame) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(19);
  VisualOdometry odometry(small_options(), camera);
  for (int i = 0; i < 4; ++i) {
    StereoFrame frame = world.draw(camera, pose_of_frame(i), time_of_frame(i));
    if (i < 2) frame.left = frame.right = uniform_image(camera, 0);
    const VoOutput output = odometry.process(frame);
    EXPECT_EQ(output.motion.valid, i == 3);
    EXPECT_EQ(odometry.anchor_time_ns().has_value(), i >= 2);
  }
}

TEST(VisualOdometry, ThePriorOnlySaysWhereToBegin) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(14);
  VisualOdometry without(small_options(), camera);
  VisualOdometry with(small_options(), camera);
  for (int i = 0; i < 2; ++i) {
    const StereoFrame frame = world.draw(camera, pose_of_frame(i), time_of_frame(i));
    const lie::SE3d truth = true_motion(camera, 0, 1);
    const lie::SO3d off = truth.rotation() * lie::SO3d::exp(Eigen::Vector3d(0.01, -0.02, 0.01));
    const VoOutput a = without.process(frame);
    const VoOutput b = with.process(frame, MotionPrior{off, std::nullopt, std::nullopt});
    if (i == 0) continue;
    ASSERT_TRUE(a.motion.valid && b.motion.valid);
    const auto difference = (a.motion.T_body0_body1.inverse() * b.motion.T_body0_body1).log();
    EXPECT_LT(difference.norm(), 3e-4);
  }
}

TEST(VisualOdometry, EstimatesADisparityOffset) {
  const StereoCamera camera = small_camera();
  StereoCamera right = camera;  // everything lies 0.5 px further left in the right image
  right.cx -= 0.5;
  const PlaneWorld world(15);
  VisualOdometry odometry(small_options(), camera);
  for (int i = 0; i < 40; ++i) {
    StereoFrame frame = world.draw(camera, pose_of_frame(i), time_of_frame(i));
    const lie::SE3d T_left_right(lie::SO3d(), Eigen::Vector3d(camera.baseline_m, 0.0, 0.0));
    frame.right = world.draw(right, pose_of_frame(i) * T_left_right, 0).left;
    odometry.process(frame);
  }
  const DisparityOffsetEstimate estimate = odometry.disparity_offset_estimate();
  EXPECT_NEAR(estimate.offset_px, 0.5, 3.0 * estimate.sigma_px + 0.05);
  EXPECT_LT(estimate.sigma_px, 0.2);
}

TEST(VisualOdometry, SkipMotionsAgreeWithTheTruth) {
  const StereoCamera camera = small_camera();
  const PlaneWorld world(16);
  VoOptions options = small_options();
  options.klt.keyframe_age = 4;
  VisualOdometry odometry(options, camera);
  int seen = 0;
  for (int i = 0; i < 7; ++i) {
    const VoOutput output =
        odometry.process(world.draw(camera, pose_of_frame(i), time_of_frame(i)));
    for (const RelativeMotion& motion : output.skip_motions) {
      const int frame0 = static_cast<int>((motion.time0_ns - time_of_frame(0)) / 50'000'000);
      expect_motion(motion, true_motion(camera, frame0, i), 1.5e-3, 5e-4);
      ++seen;
    }
  }
  EXPECT_GE(seen, 3);
}

TEST(VisualOdometry, StaysOnTheRoadOfKitti) {
  const auto root = testing::test_data() / "kitti_00_excerpt";
  IMSLAM_NEEDS(root);
  StereoCamera camera;
  camera.width = 1241;
  camera.height = 376;
  camera.fx = camera.fy = 718.856;
  camera.cx = 607.1928;
  camera.cy = 185.2157;
  camera.baseline_m = 386.1448 / 718.856;
  std::ifstream poses(root / "poses" / "00.txt");
  const auto next_pose = [&] {
    Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
    for (int k = 0; k < 12; ++k) poses >> M(k / 4, k % 4);
    return lie::SE3d::from_matrix(M);
  };
  const auto read = [&](const char* folder, int index) {
    char name[16];
    std::snprintf(name, sizeof name, "%06d.png", index);
    const cv::Mat m =
        cv::imread((root / "sequences" / "00" / folder / name).string(), cv::IMREAD_GRAYSCALE);
    return GrayImage{m.cols, m.rows, std::vector<std::uint8_t>(m.datastart, m.dataend)};
  };
  const VoOptions
      options;  // a named one: GCC 12 takes a temporary of several strings for uninitialised
  VisualOdometry odometry(options, camera);
  lie::SE3d before = next_pose();
  for (int i = 0; i < 12; ++i) {
    StereoFrame frame;
    frame.time_ns = 100'000'000LL * i;
    frame.left = read("image_0", i);
    frame.right = read("image_1", i);
    const VoOutput output = odometry.process(frame);
    if (i == 0) continue;
    const lie::SE3d now = next_pose();
    expect_motion(output.motion, before.inverse() * now, 0.05, 0.0025);
    before = now;
  }
}

TEST(VoOptions, RefusesImpossibleValues) {
  VoOptions options;
  options.shared_error = -0.1;
  EXPECT_THROW(options.validate(), InputError);
  EXPECT_THROW(VisualOdometry(options, small_camera()), InputError);
}

}  // namespace
}  // namespace imslam::vo

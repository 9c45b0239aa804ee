#include "slam/system/known_device.hpp"

#include <gtest/gtest.h>

#include "datasets/open_sequence.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/tiny_dataset.hpp"

namespace imslam::system {
namespace {

using testing::TempDir;

/// A recording, and a device file with numbers of camera and IMU.
class KnownDevice : public ::testing::Test {
 protected:
  KnownDevice() {
    testing::write_tiny_euroc(dir_.path() / "sequence");
    sequence_ = datasets::open_sequence(dir_.path() / "sequence");
    learned_ = present_device(options_, *sequence_);
    learned_.focal_error = 0.01;
    learned_.disparity_offset_px = 0.5;
    learned_.camera_rotation = {0.001, 0.0, 0.0};
    learned_.time_offset_s = 0.004;
    learned_.reading_offset.gyro = {0.01, 0.02, 0.03};
    options_.system.device = (dir_.path() / "device.yaml").string();
  }

  DeviceCalibration known() {
    write_device(options_.system.device, learned_);
    return known_device(options_, *sequence_, why_not_);
  }

  TempDir dir_;
  SlamOptions options_;
  std::unique_ptr<datasets::Sequence> sequence_;
  DeviceCalibration learned_;
  std::string why_not_;
};

TEST_F(KnownDevice, ItsOwnIsUsedAsItIs) {
  EXPECT_EQ(learned_.head, "geometric");
  const DeviceCalibration device = known();
  EXPECT_EQ(why_not_, "");
  EXPECT_EQ(device.focal_error, learned_.focal_error);
  EXPECT_EQ(device.reading_offset.gyro, learned_.reading_offset.gyro);
}

TEST_F(KnownDevice, WhatAnotherHeadFoundOfTheCameraIsLeftOutTheRestIsUsed) {
  options_.vo.head = "regression";
  const DeviceCalibration device = known();
  EXPECT_NE(why_not_.find("vo.head=geometric"), std::string::npos) << why_not_;
  EXPECT_EQ(device.focal_error, 0.0);
  EXPECT_EQ(device.disparity_offset_px, 0.0);
  EXPECT_EQ(device.camera_rotation.norm(), 0.0);
  EXPECT_EQ(device.time_offset_s, learned_.time_offset_s);
  EXPECT_EQ(device.reading_offset.gyro, learned_.reading_offset.gyro);
  learned_.head.clear();  // a file by hand, for any head
  EXPECT_EQ(known().focal_error, learned_.focal_error);
  EXPECT_EQ(why_not_, "");
}

TEST_F(KnownDevice, NothingIsTakenFromAnotherDevice) {
  learned_.device.replace(0, 4, "beef");
  learned_.head = "regression";
  const DeviceCalibration device = known();
  EXPECT_NE(why_not_.find("another device"), std::string::npos) << why_not_;
  EXPECT_EQ(why_not_.find("vo.head"), std::string::npos) << why_not_;
  EXPECT_EQ(device.reading_offset.gyro.norm(), 0.0);
}

}  // namespace
}  // namespace imslam::system

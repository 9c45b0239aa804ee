#include "slam/adaptation/device_agreement.hpp"

#include <gtest/gtest.h>

namespace imslam::adaptation {
namespace {

DeviceCalibration device(const std::string& fingerprint, double disparity_offset_px) {
  DeviceCalibration one;
  one.device = fingerprint;
  one.disparity_offset_px = disparity_offset_px;
  return one;
}

TEST(DeviceAgreement, FindsEachDeviceOnce) {
  std::vector<std::size_t> indices;
  const auto devices =
      distinct_devices({device("kitti", 0.1), device("euroc", 0.2), device("kitti", 0.3)}, indices);
  ASSERT_EQ(devices.size(), 2U);
  EXPECT_EQ(devices[0].device, "kitti");
  EXPECT_EQ(devices[1].device, "euroc");
  EXPECT_EQ(indices, (std::vector<std::size_t>{0, 1, 0}));
}

TEST(DeviceAgreement, TakesTheMeanOverTheSequencesOfADevice) {
  const auto alone = single_process();
  const std::vector<DeviceCalibration> said{device("", 0.1), device("", 0.2), device("", 0.5)};
  const auto agreed = agreed_devices(*alone, {0, 1, 0}, 2, [&](std::size_t s) { return said[s]; });
  ASSERT_EQ(agreed.size(), 2U);
  EXPECT_NEAR(agreed[0].disparity_offset_px, 0.3, 1e-15);
  EXPECT_EQ(agreed[1].disparity_offset_px, 0.2);
}

}  // namespace
}  // namespace imslam::adaptation

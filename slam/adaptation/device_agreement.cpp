#include "slam/adaptation/device_agreement.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "slam/base/packed_strings.hpp"

namespace imslam::adaptation {
namespace {

/// Focal error, disparity offset, time offset, camera rotation.
using Numbers = std::array<double, 6>;

Numbers numbers_of(const DeviceCalibration& device) {
  const Eigen::Vector3d& turn = device.camera_rotation;
  return {device.focal_error,
          device.disparity_offset_px,
          device.time_offset_s,
          turn.x(),
          turn.y(),
          turn.z()};
}

DeviceCalibration device_of(const Numbers& n) {
  DeviceCalibration device;
  device.focal_error = n[0];
  device.disparity_offset_px = n[1];
  device.time_offset_s = n[2];
  device.camera_rotation = {n[3], n[4], n[5]};
  return device;
}

std::string bytes_of(const Numbers& numbers) {
  std::string bytes(sizeof(numbers), '\0');
  std::memcpy(bytes.data(), numbers.data(), sizeof(numbers));
  return bytes;
}

Numbers numbers_in(const std::string& bytes) {
  Numbers numbers{};
  std::memcpy(numbers.data(), bytes.data(), std::min(bytes.size(), sizeof(numbers)));
  return numbers;
}

}  // namespace

std::vector<DeviceCalibration> distinct_devices(const std::vector<DeviceCalibration>& of_sequences,
                                                std::vector<std::size_t>& indices) {
  std::vector<DeviceCalibration> devices;
  indices.clear();
  for (const DeviceCalibration& device : of_sequences) {
    const auto known = std::find_if(devices.begin(), devices.end(), [&](const auto& other) {
      return other.device == device.device;
    });
    indices.push_back(static_cast<std::size_t>(known - devices.begin()));
    if (known == devices.end()) devices.push_back(device);
  }
  return devices;
}

std::vector<DeviceCalibration> agreed_devices(
    ProcessGroup& group,
    const std::vector<std::size_t>& indices,
    std::size_t devices,
    const std::function<DeviceCalibration(std::size_t sequence)>& said) {
  const auto mine = gather_items(group, indices.size(),
                                 [&](std::size_t s) { return bytes_of(numbers_of(said(s))); });
  const auto all = unpack_strings(group.broadcast(pack_strings(mine)));
  std::vector<Numbers> sums(devices, Numbers{});
  std::vector<double> counts(devices, 0.0);
  for (std::size_t s = 0; s < all.size(); ++s) {
    const Numbers numbers = numbers_in(all[s]);
    for (std::size_t k = 0; k < numbers.size(); ++k) sums[indices[s]][k] += numbers[k];
    counts[indices[s]] += 1.0;
  }
  std::vector<DeviceCalibration> agreed;
  for (std::size_t i = 0; i < devices; ++i) {
    for (double& number : sums[i]) number /= counts[i];
    agreed.push_back(device_of(sums[i]));
  }
  return agreed;
}

std::string packed(const DeviceCalibration& device) {
  return pack_strings({device.device, bytes_of(numbers_of(device))});
}

DeviceCalibration unpacked_device(const std::string& bytes) {
  const auto parts = unpack_strings(bytes);
  DeviceCalibration device = device_of(numbers_in(parts.at(1)));
  device.device = parts.at(0);
  return device;
}

}  // namespace imslam::adaptation

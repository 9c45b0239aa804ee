#pragma once

#include <functional>
#include <string>
#include <vector>

#include "slam/base/process_group.hpp"
#include "slam/sensors/device_calibration.hpp"

namespace imslam::adaptation {

/// The devices that recorded some sequences, each once, in the order in which they come up;
/// `indices`: which of them recorded sequence s.
std::vector<DeviceCalibration> distinct_devices(const std::vector<DeviceCalibration>& of_sequences,
                                                std::vector<std::size_t>& indices);

/// What several sequences say of their devices: for each device the mean over its sequences.
/// `said(s)` is called on the rank that owns sequence s; all ranks get the same. Collective.
/// Readings' offsets are not spoken of.
std::vector<DeviceCalibration> agreed_devices(
    ProcessGroup& group,
    const std::vector<std::size_t>& indices,
    std::size_t devices,
    const std::function<DeviceCalibration(std::size_t sequence)>& said);

/// For another process, bit by bit: fingerprint and calibration, no offsets of readings.
std::string packed(const DeviceCalibration& device);
DeviceCalibration unpacked_device(const std::string& bytes);

}  // namespace imslam::adaptation

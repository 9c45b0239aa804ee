#pragma once

#include <string>

#include "datasets/sequence.hpp"
#include "slam/sensors/device_calibration.hpp"
#include "slam/system/slam_options.hpp"

namespace imslam::system {

/// What is known of the device that recorded a sequence: that of the file options.system.device, if
/// it is of this device, or of the file FINGERPRINT.yaml in the folder of that name. If there is
/// none, nothing, and `why_not` says so; without a name both are empty. What another head than
/// options.vo.head found of the camera makes up for that head's own errors: it is left out, and
/// `why_not` says that too.
/// Throws what read_device() throws.
DeviceCalibration known_device(const SlamOptions& options,
                               const datasets::Sequence& sequence,
                               std::string& why_not);

/// The same, with its fingerprint and the present head, to be refined and written.
DeviceCalibration present_device(const SlamOptions& options, const datasets::Sequence& sequence);

/// The options with what is known of a device in place of guesses.
SlamOptions with_device(const SlamOptions& options, const DeviceCalibration& device);

}  // namespace imslam::system

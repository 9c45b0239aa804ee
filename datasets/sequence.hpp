#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/sensors/calibration.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/stereo.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::datasets {

/// The inertial half of a sequence, in the body frame (= IMU frame) and SI units.
struct ImuData {
  ImuNoise noise;
  std::vector<ImuSample> samples;  ///< strictly increasing stamps, all finite
  std::size_t dropped = 0;         ///< samples that were not finite, repeated or out of order
};

/// A recorded stereo(-inertial) sequence, whatever its format on disk.
///
/// Frames are decoded and rectified when asked for; only the index and the IMU samples live in
/// memory. One thread at a time may call read_frame().
class Sequence {
 public:
  virtual ~Sequence() = default;

  virtual std::string format() const = 0;  ///< "euroc", "tumvi", "kitti_odometry", ...
  virtual std::string name() const = 0;    ///< e.g. "MH_01_easy", "00"
  virtual const std::filesystem::path& root() const = 0;

  /// The rectified pair. Body is the IMU, or the left camera where imu() is empty.
  virtual const StereoCamera& camera() const = 0;

  virtual std::size_t frame_count() const = 0;
  virtual std::int64_t frame_time_ns(std::size_t index) const = 0;

  /// Decodes and rectifies. A missing or damaged image comes back empty and is logged once.
  virtual StereoFrame read_frame(std::size_t index) = 0;

  virtual const std::optional<ImuData>& imu() const = 0;

  /// Ground truth, if there is one; its frame says whether it is of the body or of the left
  /// (unrectified) camera. T_body_truth carries it to the body.
  virtual const std::optional<PosePath>& truth() const = 0;
  virtual const lie::SE3d& T_body_truth() const = 0;

  /// Every file whose content decides the result (index files, calibration, csv), for the manifest.
  virtual std::vector<std::filesystem::path> input_files() const = 0;
};

}  // namespace imslam::datasets

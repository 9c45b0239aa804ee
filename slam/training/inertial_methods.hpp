#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "imu_net/static_detector.hpp"
#include "slam/training/open_integration.hpp"

namespace imslam::training {

/// A way to get rid of a sensor's errors: one row of the table.
struct InertialMethod {
  struct Result {
    InertialCorrection correction;
    std::string remark;  ///< what people should know about this log; may be empty
  };

  std::string name;
  std::function<Result(const InertialLog&)> correct;
};

/// The readings as they are: the datasheet's white noise, nothing said of the bias.
InertialMethod raw_method();

/// What an IMU alone learns at rest: the gyro bias is the mean of the first still second
/// (imu::align_to_gravity) and is subtracted from the whole log, sure to within its own scatter and
/// a random walk since. The accelerometer's bias cannot be seen at rest: it stays as unknown as the
/// sensor's kind allows. Without a rest: as raw.
InertialMethod rest_bias_method(const imu::StaticDetectorOptions& options = {});

/// From a function that corrects the readings themselves, e.g. a network.
InertialMethod corrected_method(std::string name,
                                std::function<imu::CorrectedSamples(const InertialLog&)> correct);

/// Start of the first second at rest, sought in steps of a quarter of a second [ns].
std::optional<std::int64_t> first_still_second(const InertialLog& log,
                                               const imu::StaticDetectorOptions& options = {});

}  // namespace imslam::training

#pragma once

#include <string>
#include <vector>

#include "imu_net/imu_network.hpp"
#include "slam/training/imu_training_options.hpp"
#include "slam/training/inertial_log.hpp"
#include "slam/training/open_integration.hpp"

namespace imslam::training {

/// How well corrected readings integrate over 1, 5 and 10 s.
struct ImuQuality {
  double loss = 0.0;           ///< mean over all windows, as in training
  double rotation_deg = 0.0;   ///< RMS over 10 s
  double rotation_gain = 0.0;  ///< of the raw readings' over it: how many times better
  double position_m = 0.0;     ///< RMS over 10 s
  double position_gain = 0.0;  ///< likewise
  double nees[3] = {0, 0, 0};  ///< per degree of freedom, over 1, 5, 10 s: 1 is right; median
  double inside_95 = 0.0;      ///< share of all windows within their 95 % bound

  std::string text() const;  ///< one line
  std::string row() const;   ///< all figures but the loss, comma separated
  static std::string columns();
};

/// A fixed set of logs that training never draws, or named real ones: what chooses among weights.
class ImuValidation {
 public:
  explicit ImuValidation(const ImuTrainingOptions& options);

  ImuQuality evaluate(const imu::ImuNetwork<float>& network) const;

  std::string description() const { return description_; }

 private:
  /// Errors of one log over each length, corrected by `network` or raw (null).
  std::vector<OpenIntegration> integrate(const InertialLog& log,
                                         const imu::ImuNetwork<float>* network) const;
  std::vector<OpenIntegration> integrate_all(const imu::ImuNetwork<float>* network) const;

  std::vector<InertialLog> logs_;
  std::vector<OpenScore> raw_;  ///< per length
  std::string description_;
};

/// Reads the logs of a comma-separated list; see read_inertial_log().
std::vector<InertialLog> read_inertial_logs(const std::string& list);

}  // namespace imslam::training

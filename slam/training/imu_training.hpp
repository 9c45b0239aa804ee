#pragma once

#include <memory>
#include <string>
#include <vector>

#include "imu_net/imu_network.hpp"
#include "slam/learner/network_training.hpp"
#include "slam/training/correction_sample.hpp"
#include "slam/training/imu_training_options.hpp"
#include "slam/training/imu_validation.hpp"

namespace imslam::training {

/// Trains the IMU network; a sample is one log, a stretch of a real one or simulated.
class ImuTraining : public learner::NetworkTraining {
 public:
  /// Reads the real logs, if any. Throws InputError on bad options or logs.
  explicit ImuTraining(const ImuTrainingOptions& options);

  learner::ValidationRecord look() override;
  std::string log_columns() const override { return ImuQuality::columns(); }
  std::string name() const override { return "imu_network"; }
  nn::ModelCard card() const override;

 private:
  nn::Var sample_loss(nn::Tape<float>& tape, std::size_t slot) override;
  InertialLog draw_log(std::uint64_t index, Random& random) const;

  ImuTrainingOptions options_;
  InertialLogGenerator generator_;
  std::vector<InertialLog> logs_;
  imu::ImuNetwork<float> network_;
  std::unique_ptr<ImuValidation> validation_;  ///< made when first asked for
};

}  // namespace imslam::training

#include "slam/training/imu_training_options.hpp"

#include "slam/training/bounds.hpp"

namespace imslam::training {

void ImuTrainingOptions::describe(Config& config) {
  describe_training(config);
  config.field("logs", logs, "real logs with truth, comma separated; empty: simulated sensors");
  config.field("validation_logs", validation_logs,
               "real logs that choose among the weights; empty: those of the training");
  config.field("windows", windows, "stretches that are integrated per log and step");
  config.field("least_window_s", least_window_s, "shortest stretch [s]");
  config.field("most_window_s", most_window_s, "longest stretch [s]");
  config.field("crop_s", crop_s, "length of the part of a real log that one sample uses [s]");
  config.field("sensor_offset", sensor_offset,
               "also learn the constant offset of the one sensor that made the logs");
  config.section("simulation", simulation);
}

void ImuTrainingOptions::validate() const {
  validate_training();
  require_within("train.windows", windows, 1, 1000);
  require_within("train.least_window_s", least_window_s, 0.05, 60.0);
  require_within("train.most_window_s", most_window_s, least_window_s, 60.0);
  require_within("train.crop_s", crop_s, 2.0, 1e4);
  simulation.validate();
}

}  // namespace imslam::training

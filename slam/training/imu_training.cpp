#include "slam/training/imu_training.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "slam/base/time.hpp"

namespace imslam::training {
namespace {

const ImuTrainingOptions& validated(const ImuTrainingOptions& options) {
  options.validate();
  return options;
}

imu::ImuNetwork<float> make_network(const ImuTrainingOptions& options) {
  Random random(static_cast<std::uint64_t>(options.seed));
  imu::ImuNetwork<float> network(imu::ImuNetworkSizes(), random);
  network.sensor_offset.trainable = options.sensor_offset;
  return network;
}

nn::ParameterList<float> parameters_of(imu::ImuNetwork<float>& network) {
  nn::ParameterList<float> list;
  network.collect(list);
  return list;
}

}  // namespace

ImuTraining::ImuTraining(const ImuTrainingOptions& options)
    : NetworkTraining(validated(options), learner::text_of_training(options)),
      options_(options),
      generator_(options.simulation),
      logs_(read_inertial_logs(options.logs)),
      network_(make_network(options)) {
  adopt(parameters_of(network_));
}

/// Half of the crops of a real log start where it starts: there the sensor is at rest.
InertialLog ImuTraining::draw_log(std::uint64_t index, Random& random) const {
  if (logs_.empty()) return generator_.make(index);
  const InertialLog& log = logs_[index % logs_.size()];
  const double spare_s = std::max(
      0.0, to_seconds(log.truth.back().time_ns - log.truth.front().time_ns) - options_.crop_s);
  const bool from_start = random.chance(0.5);
  const double start_s = random.uniform(0.0, 1.0) * spare_s;
  return cropped(log, from_start ? 0.0 : start_s, options_.crop_s);
}

nn::Var ImuTraining::sample_loss(nn::Tape<float>& tape, std::size_t slot) {
  const std::uint64_t index =
      static_cast<std::uint64_t>(step_count()) * static_cast<std::uint64_t>(options_.batch) + slot;
  Random random = Random(static_cast<std::uint64_t>(options_.seed)).fork(index);
  CorrectionSample sample;
  make_correction_sample(draw_log(index, random),
                         {options_.windows, options_.least_window_s, options_.most_window_s},
                         random, sample);
  const auto frames = imu::frame_tensors<float>(sample.frames, sample.log.noise);
  const imu::ImuAnswer answer = network_.forward(tape, frames, network_.gru.zero_state(tape, 3));
  return correction_loss(tape, answer, sample.task);
}

learner::ValidationRecord ImuTraining::look() {
  if (!validation_) validation_ = std::make_unique<ImuValidation>(options_);
  const ImuQuality quality = with_average([this] { return validation_->evaluate(network_); });
  return {quality.loss, quality.text(), quality.row()};
}

nn::ModelCard ImuTraining::card() const {
  nn::ModelCard card;
  card.what =
      "IMU network of imslam: corrections of gyroscope and accelerometer, added noise, remaining "
      "bias uncertainty, from raw readings (causal, 50 to 1000 Hz)";
  const auto count = static_cast<std::int64_t>(step_count()) * options_.batch;
  card.data = logs_.empty()
                  ? fmt::format(
                        "{} simulated logs made by this program (drone, hand, car, rover; "
                        "tactical to phone sensors)",
                        count)
                  : fmt::format("{} crops of the real logs {}", count, options_.logs);
  card.seed = fmt::format("{}", options_.seed);
  card.metrics = validation_ ? validation_->description() : "not validated";
  card.limits =
      logs_.empty()
          ? "trained on simulation only; without a still moment the bias about the vertical is "
            "found slowly"
          : "trained on one kind of sensor; with train.sensor_offset it fits that one sensor only";
  return card;
}

}  // namespace imslam::training

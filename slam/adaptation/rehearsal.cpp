#include "slam/adaptation/rehearsal.hpp"

#include "slam/base/random.hpp"
#include "slam/training/correction_sample.hpp"

namespace imslam::adaptation {
namespace {

constexpr training::WindowDraw kWindows{12, 0.1, 10.0};  // as in the training of the network
constexpr double kShortest_s = 15.0;
constexpr double kLongest_s = 45.0;
constexpr int kOtherSeed = 7919;  // not the logs of the training

}  // namespace

training::InertialLogOptions rehearsal_logs(int seed) {
  training::InertialLogOptions options;
  options.seed = kOtherSeed + seed;
  options.min_duration_s = kShortest_s;
  options.max_duration_s = kLongest_s;
  return options;
}

nn::Var rehearsal(nn::Tape<float>& tape,
                  const imu::ImuNetwork<float>& network,
                  const training::InertialLogGenerator& generator,
                  std::uint64_t index) {
  const Random random = Random(kOtherSeed).fork(index);
  training::CorrectionSample sample;
  training::make_correction_sample(generator.make(index), kWindows, random, sample);
  const auto frames = imu::frame_tensors<float>(sample.frames, sample.log.noise);
  const imu::ImuAnswer answer =
      network.forward(tape, frames, network.gru.zero_state(tape, 3), false);
  return imu::correction_loss(tape, answer, sample.task);
}

}  // namespace imslam::adaptation

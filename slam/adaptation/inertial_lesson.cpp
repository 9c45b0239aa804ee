#include "slam/adaptation/inertial_lesson.hpp"

#include <algorithm>

#include "imu_net/edge_noise_cost.hpp"
#include "slam/base/time.hpp"
#include "slam/nn/ops/arithmetic.hpp"
#include "slam/nn/ops/pointwise.hpp"
#include "slam/training/correction_sample.hpp"

namespace imslam::adaptation {
namespace {

using nn::Var;

constexpr double kDimensions = 9.0;
constexpr training::WindowDraw kWindows{24, 0.51, 10.0};

/// A crop of the log; half of them begin where it begins.
training::InertialLog draw_crop(const training::InertialLog& log, double length_s, Random& random) {
  const double span_s = to_seconds(log.truth.back().time_ns - log.truth.front().time_ns);
  const double spare_s = std::max(0.0, span_s - length_s);
  const bool from_start = random.chance(0.5);
  const double place = random.uniform();
  if (spare_s <= 0.0) return log;  // with all readings of before the first frame
  return training::cropped(log, from_start ? 0.0 : place * spare_s, length_s);
}

imu::EdgeNoiseTask edge_task(const InertialClass& of, const training::CorrectionSample& sample) {
  imu::EdgeNoiseTask task;
  task.samples = &sample.log.samples;
  task.datasheet = sample.log.noise;
  task.base = sample.log.noise;
  task.base.gyro_noise_density *= of.slam.imu_network.noise_factor;
  task.base.accel_noise_density *= of.slam.imu_network.noise_factor;
  task.frame_times = sample.task.frame_times;
  task.options = of.slam.preintegration;
  const auto& edges = of.teacher.graph().inertial_edges();
  const std::int64_t first_ns = sample.log.samples.front().time_ns;
  const std::int64_t last_ns = sample.log.samples.back().time_ns;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const ImuMotion& motion = edges[e].motion;
    if (!of.counts(static_cast<std::size_t>(edges[e].to)) || motion.time0_ns < first_ns ||
        motion.time1_ns > last_ns) {
      continue;
    }
    task.edges.push_back({motion.time0_ns, motion.time1_ns, motion.bias, motion.time_offset_s,
                          [&of, e](const ImuMotion& now) {
                            const auto l = of.teacher.inertial(e, now);
                            return imu::CovarianceSlope{l.nll, l.gradient.covariance};
                          }});
  }
  return task;
}

/// Windows that touch what is held out do not teach.
void drop_held_out(const InertialClass& of, training::CorrectionSample& sample) {
  const auto& states = of.teacher.graph().states();
  const auto touches = [&](const ImuMotion& window) {
    const auto first = std::lower_bound(
        states.begin(), states.end(), window.time0_ns,
        [](const pgo::State& state, std::int64_t time) { return state.time_ns < time; });
    for (auto state = first; state != states.end() && state->time_ns <= window.time1_ns; ++state) {
      if (!of.counts(static_cast<std::size_t>(state - states.begin()))) return true;
    }
    return false;
  };
  auto& windows = sample.task.windows;
  std::vector<ImuMotion> kept;
  std::copy_if(windows.begin(), windows.end(), std::back_inserter(kept),
               [&](const ImuMotion& window) { return !touches(window); });
  // A short log has no long window outside of what is held out: better all than none.
  if (2 * kept.size() >= windows.size()) windows = std::move(kept);
}

}  // namespace

Var inertial_lesson(nn::Tape<float>& tape, const InertialClass& of, Random random) {
  training::CorrectionSample sample;
  training::make_correction_sample(draw_crop(of.log, of.options.imu_crop_s, random), kWindows,
                                   random, sample);
  if (sample.frames.empty()) return tape.constant(nn::Tensor<float>({1}));
  drop_held_out(of, sample);
  const auto frames = imu::frame_tensors<float>(sample.frames, sample.log.noise);
  const imu::ImuAnswer answer =
      of.network.forward(tape, frames, of.network.gru.zero_state(tape, 3));
  const Var open = imu::correction_loss(tape, answer, sample.task);
  const Var edges = imu::edge_noise_cost(tape, answer, edge_task(of, sample));
  return add(tape, open, scale(tape, edges, of.options.graph_weight / kDimensions));
}

}  // namespace imslam::adaptation

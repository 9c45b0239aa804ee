#include "imu_net/edge_noise_cost.hpp"

#include <algorithm>

#include "imu_net/imu_corrector.hpp"
#include "imu_net/preintegration_gradient.hpp"
#include "slam/base/time.hpp"

namespace imslam::imu {
namespace {

using nn::Index;
using nn::Var;

/// Place of an axis and sensor in an answer [3, T, 2].
Index place(int axis, Index bins, Index bin, int sensor) {
  return 2 * (axis * bins + bin) + sensor;
}

/// The readings with the variances that an answer adds, and which bin each has them from.
struct NoisySamples {
  std::vector<ImuSample> samples;
  std::vector<Index> bins;  ///< -1: before the first
};

template <typename S>
NoisySamples noisy_samples(const nn::Tape<S>& tape, Var edge_noise, const EdgeNoiseTask& task) {
  const auto bins = static_cast<Index>(task.frame_times.size());
  const S* const said = tape.data(edge_noise);
  NoisySamples noisy{*task.samples, {}};
  noisy.bins.reserve(noisy.samples.size());
  Index bin = -1;
  for (ImuSample& sample : noisy.samples) {
    while (bin + 1 < bins &&
           task.frame_times[static_cast<std::size_t>(bin + 1)] <= sample.time_ns) {
      ++bin;
    }
    noisy.bins.push_back(bin);
    for (int axis = 0; bin >= 0 && axis < 3; ++axis) {
      sample.gyro_variance[axis] = added_variance(
          task.datasheet.gyro_noise_density, static_cast<double>(said[place(axis, bins, bin, 0)]));
      sample.accel_variance[axis] = added_variance(
          task.datasheet.accel_noise_density, static_cast<double>(said[place(axis, bins, bin, 1)]));
    }
  }
  return noisy;
}

/// Adds the slopes of one edge to those of the answer; false if the edge does not count.
bool add_edge(const EdgeNoiseTask::Edge& edge,
              const EdgeNoiseTask& task,
              const NoisySamples& noisy,
              double& cost,
              double* slopes) {
  const std::int64_t offset_ns = to_nanoseconds(edge.time_offset_s);
  const ImuRange around =
      ImuRange(noisy.samples).around(edge.time0_ns + offset_ns, edge.time1_ns + offset_ns);
  PreintegrationRecord record;
  const ImuMotion motion = preintegrate(around, edge.time0_ns, edge.time1_ns, edge.bias, task.base,
                                        edge.time_offset_s, task.options, &record);
  if (!motion.valid || motion.degraded) return false;
  const CovarianceSlope slope = edge.cost(motion);
  cost += slope.cost;
  MotionGradient dU;
  dU.covariance = slope.by_covariance;
  std::vector<SampleGradient> gradients(around.size());
  add_preintegration_gradient(record, dU, gradients.data());
  const auto first = static_cast<std::size_t>(around.begin() - noisy.samples.data());
  const auto bins = static_cast<Index>(task.frame_times.size());
  for (std::size_t i = 0; i < gradients.size(); ++i) {
    const Index bin = noisy.bins[first + i];
    if (bin < 0) continue;
    const ImuSample& sample = noisy.samples[first + i];
    for (int axis = 0; axis < 3; ++axis) {  // variance = density^2 e^{2 x}
      slopes[place(axis, bins, bin, 0)] +=
          2.0 * sample.gyro_variance[axis] * gradients[i].gyro_variance[axis];
      slopes[place(axis, bins, bin, 1)] +=
          2.0 * sample.accel_variance[axis] * gradients[i].accel_variance[axis];
    }
  }
  return true;
}

}  // namespace

template <typename S>
Var edge_noise_cost(nn::Tape<S>& tape, const ImuAnswer& answer, const EdgeNoiseTask& task) {
  const Index numbers = 6 * static_cast<Index>(task.frame_times.size());
  nn::expects_shape(tape.shape(answer.edge_noise).size() == numbers,
                    "edge_noise_cost: an answer for each frame", tape.shape(answer.edge_noise));
  double* const slopes = tape.template keep<double>(numbers);
  std::fill_n(slopes, numbers, 0.0);
  const NoisySamples noisy = noisy_samples(tape, answer.edge_noise, task);
  double sum = 0.0;
  int count = 0;
  for (const auto& edge : task.edges) count += add_edge(edge, task, noisy, sum, slopes) ? 1 : 0;
  const double share = count > 0 ? 1.0 / count : 0.0;
  const Var y = tape.make({});
  tape.data(y)[0] = static_cast<S>(share * sum);
  const Var edge_noise = answer.edge_noise;
  return tape.record(y, {edge_noise}, [=](nn::Tape<S>& back) {
    const double dU = share * static_cast<double>(back.gradient_data(y)[0]);
    S* const to = back.gradient_data(edge_noise);
    for (Index i = 0; i < numbers; ++i) to[i] += static_cast<S>(dU * slopes[i]);
  });
}

template Var edge_noise_cost(nn::Tape<float>&, const ImuAnswer&, const EdgeNoiseTask&);
template Var edge_noise_cost(nn::Tape<double>&, const ImuAnswer&, const EdgeNoiseTask&);

}  // namespace imslam::imu

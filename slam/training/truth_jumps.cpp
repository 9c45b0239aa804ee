#include "slam/training/truth_jumps.hpp"

#include <algorithm>

#include "slam/base/parallel.hpp"
#include "slam/base/time.hpp"
#include "slam/training/truth_bend.hpp"

namespace imslam::training {

std::vector<std::size_t> find_jumps(imu::ImuRange samples,
                                    const ImuNoise& noise,
                                    const Trajectory& truth,
                                    const GravityFit& gravity,
                                    const JumpOptions& options) {
  std::vector<std::size_t> jumps;
  if (truth.size() < 3) return jumps;
  std::vector<Eigen::Vector3d> bends(truth.size(), Eigen::Vector3d::Zero());
  parallel_for(truth.size() - 2, [&](std::size_t i) {
    const StampedBias* bias = bias_at(gravity.biases, truth.times_ns[i]);
    const Bend b = bend(samples, noise, truth, {i, i + 1, i + 2},
                        bias == nullptr ? ImuBias() : bias->bias, gravity.gravity_world);
    if (b.usable) bends[i + 1] = b.residual.tail<3>();
  });
  std::vector<double> wrong(truth.size() - 1);
  for (std::size_t i = 0; i < wrong.size(); ++i) wrong[i] = (bends[i] - bends[i + 1]).norm() / 2.0;
  std::vector<double> sorted = wrong;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double bound = std::max(options.smallest_m, options.times_typical * *middle);
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    const double step_s = to_seconds(truth.times_ns[i + 1] - truth.times_ns[i]);
    if (wrong[i] > bound || step_s > options.largest_step_s) jumps.push_back(i + 1);
  }
  return jumps;
}

}  // namespace imslam::training

#include "slam/system/online_estimator.hpp"

#include <algorithm>
#include <utility>

#include "pgo/prediction.hpp"
#include "slam/base/time.hpp"
#include "slam/system/batch_estimator.hpp"
#include "slam/system/conflicts.hpp"
#include "slam/system/inertial_motions.hpp"

namespace imslam::system {
namespace {

/// Fewer leave the biases so open that the newest pose swings while they settle.
constexpr std::size_t kFirstTry = 40;  // [frames]
constexpr std::size_t kRetry = 20;     // [frames]
/// A start over more frames than this would stall the stream; the newest ones must do.
constexpr std::size_t kLongestStart = 200;  // [frames]
/// A gyro that contradicts vision for longer may be the one that is wrong.
constexpr double kLongestRefusal_s = 2.0;

/// What begins at that frame.
Measurements measurements_from(const Measurements& all, std::size_t first) {
  if (first == 0) return all;
  Measurements late = all;
  const std::int64_t start_ns = all.times_ns[first];
  const auto early = [start_ns](const RelativeMotion& motion) {
    return motion.time0_ns < start_ns;
  };
  late.times_ns.erase(late.times_ns.begin(),
                      late.times_ns.begin() + static_cast<std::ptrdiff_t>(first));
  for (auto* motions : {&late.odometry, &late.skips}) {
    motions->erase(std::remove_if(motions->begin(), motions->end(), early), motions->end());
  }
  return late;
}

}  // namespace

void OnlineEstimator::update(const Measurements& measurements,
                             const std::function<Estimate()>& disparity_offset) {
  if (measurements.readings().empty()) return;
  if (window_) {
    add_newest(measurements);
  } else if (measurements.times_ns.size() >= std::max(next_try_, kFirstTry)) {
    try_to_start(measurements, disparity_offset());
  }
}

void OnlineEstimator::try_to_start(const Measurements& measurements,
                                   const Estimate& disparity_offset) {
  const std::size_t count = measurements.times_ns.size();
  next_try_ = count + std::max(kRetry, count / 4);
  const std::size_t first = count > kLongestStart ? count - kLongestStart : 0;
  SlamOptions options = options_;
  options.system.covariances = false;
  options.system.preset = "default";
  options.pgo.kernel_width = options_.window.kernel_width;
  // How the camera is turned takes turns to be seen; while it becomes known the present would jump.
  options.pgo.estimate_camera_rotation = false;
  const BatchEstimate start =
      estimate_batch(measurements_from(measurements, first), disparity_offset, options);
  if (!start.inertial || !start.report.converged) return;
  pgo::PoseVelocityGraph graph(start.graph_options);
  graph.data() = start.graph;
  for (const pgo::State& state : graph.states()) {
    trajectory_.add(state.time_ns, state.nav.T_world_body);
  }
  first_frame_ = first;
  seen_ = static_cast<int>(graph.states().size()) - 1;
  window_.emplace(std::move(graph), options_.window);
}

pgo::State OnlineEstimator::foretell(const ImuMotion& motion) const {
  const Eigen::Vector3d gravity =
      options_.pgo.gravity_magnitude * window_->globals().gravity_direction;
  return pgo::predict(window_->newest(), motion, gravity, window_->globals().time_offset_s);
}

bool OnlineEstimator::refuses(const RelativeMotion& motion,
                              int from,
                              const pgo::State& guess,
                              const ImuMotion& imu_motion) {
  if (!imu_motion.valid || imu_motion.degraded || from < window_->first()) {
    contradicted_ns_.reset();
    return false;
  }
  const lie::SO3d turn = window_->state(from).nav.T_world_body.rotation().inverse() *
                         guess.nav.T_world_body.rotation();
  const double intervals = to_seconds(motion.time1_ns - motion.time0_ns) / imu_motion.dt_s;
  const double variance = intervals * imu_motion.covariance.topLeftCorner<3, 3>().trace();
  if (!contradicts(turn, variance, motion)) {
    contradicted_ns_.reset();
    return false;
  }
  if (!contradicted_ns_) contradicted_ns_ = motion.time1_ns;
  return to_seconds(motion.time1_ns - *contradicted_ns_) <= kLongestRefusal_s;
}

void OnlineEstimator::add_newest(const Measurements& measurements) {
  const auto& times_ns = measurements.times_ns;
  const int newest = window_->end() - 1;
  const pgo::State& last = window_->newest();
  const ImuMotion imu_motion =
      integrate_interval(measurements, last.time_ns, times_ns.back(), last.bias,
                         window_->globals().time_offset_s, options_.preintegration);
  pgo::State guess = imu_motion.valid ? foretell(imu_motion) : last;
  guess.time_ns = times_ns.back();
  const int added = window_->add_state(guess);
  bool connected = imu_motion.valid && window_->add_imu_edge(newest, added, imu_motion);
  if (!measurements.odometry.empty() && measurements.odometry.back().time1_ns == times_ns.back()) {
    const RelativeMotion& motion = measurements.odometry.back();
    const auto from = measurements.frame_at(motion.time0_ns);
    const int start = from ? number_of(*from) : -1;
    if (from && !refuses(motion, start, guess, imu_motion)) {
      connected |= window_->add_visual_edge(start, added, motion);
      seen_ = added;
    }
  }
  if (!connected) {
    Trajectory step;
    step.add(last.time_ns, window_->state(newest).nav.T_world_body);
    step.add(guess.time_ns, guess.nav.T_world_body);
    window_->add_visual_edge(newest, added, bridge(step, 1));
  }
  window_->update(seen_);
  trajectory_.add(times_ns.back(), window_->newest().nav.T_world_body);
}

}  // namespace imslam::system

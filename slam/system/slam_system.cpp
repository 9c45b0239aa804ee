#include "slam/system/slam_system.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "imu_net/preintegration.hpp"
#include "imu_net/vibration_meter.hpp"
#include "slam/base/error.hpp"
#include "slam/base/time.hpp"
#include "slam/system/batch_estimator.hpp"
#include "slam/system/calibration_doubts.hpp"
#include "slam/system/front_end.hpp"
#include "slam/system/inertial_front_end.hpp"
#include "slam/system/known_device.hpp"
#include "slam/system/map_sampler.hpp"
#include "slam/system/measurements.hpp"
#include "slam/system/online_estimator.hpp"
#include "slam/system/resources.hpp"
#include "vo_net/loop_closer.hpp"
#include "vo_net/visual_odometry.hpp"

namespace imslam::system {
namespace {

constexpr double kLongestPrediction_s = 5.0;  // after an outage that long the gyro knows nothing
constexpr double kKnownGyroBias = 2e-3;       // [rad/s] how well the sliding window knows it
constexpr double kKnownVelocity = 0.05;       // [m/s] likewise
constexpr double kKnownAcceleration = 1.0;    // [m/s^2] what tilt, bias and scale may add up to
constexpr double kGyroScale = 0.01;           // [1] and how far its scale and axes may be off

}  // namespace

class SlamSystem::State {
 public:
  State(const SlamOptions& options,
        const StereoCamera& camera,
        const std::optional<ImuNoise>& imu_noise,
        FrontEnd front_end,
        FrameLoader load)
      : options_(options),
        camera_(camera),
        odometry_(options_.vo,
                  camera,
                  std::move(front_end.matcher),
                  std::move(front_end.pose_head),
                  std::move(front_end.motion_noise)),
        online_(options_),
        map_sampler_(camera, options_.system),
        inertial_(imu_noise.has_value()) {
    measurements_.T_body_left = camera.T_body_left;
    odometry_.set_disparity_offset(options_.vo.offset.prior);
    result_.models = std::move(front_end.models);
    if (options.system.loops) loops_.emplace(options.loops, options.vo, camera, std::move(load));
    if (!imu_noise) return;
    measurements_.imu_noise = *imu_noise;
    if (imu_noise->gyro_noise_density >= options.system.coarse_gyro_noise) {
      measurements_.gyro_shape_sigma = options.system.gyro_shape_prior;
    }
    measurements_.imu_noise.gyro_random_walk *= options.system.gyro_walk_factor;
    measurements_.imu_noise.accel_random_walk *= options.system.accel_walk_factor;
    if (front_end.imu_network) {
      inertial_front_end_.emplace(std::move(front_end.imu_network), *imu_noise);
      measurements_.imu_noise.gyro_noise_density *= options.imu_network.noise_factor;
      measurements_.imu_noise.accel_noise_density *= options.imu_network.noise_factor;
      return;
    }
    measurements_.imu_noise.gyro_noise_density *= options.system.gyro_noise_factor;
    measurements_.imu_noise.accel_noise_density *= options.system.accel_noise_factor;
    if (options.system.vibration) vibration_.emplace(measurements_.imu_noise);
  }

  void add_earlier_imu(const ImuSample& sample) {
    if (inertial_front_end_) inertial_front_end_->add(sample);
    if (vibration_) vibration_->add(sample);
  }

  void add_imu(const ImuSample& sample) {
    ++result_.counters.imu_samples;
    const imu::ImuRange known = measurements_.readings();
    if (!known.empty() && sample.time_ns <= known[known.size() - 1].time_ns) {
      ++result_.counters.imu_dropped;
      return;
    }
    if (!inertial_front_end_) return add_raw(sample);
    measurements_.imu.push_back(inertial_front_end_->add(sample));
    if (options_.imu_network.beliefs) measurements_.bias_beliefs = inertial_front_end_->beliefs();
  }

  void add_raw(const ImuSample& sample) {
    if (!vibration_) return measurements_.lend_imu(sample);
    const ImuSample reading = vibration_->add(sample);
    const bool shakes = reading.gyro_variance != sample.gyro_variance ||
                        reading.accel_variance != sample.accel_variance;
    if (shakes) return measurements_.keep_imu(reading);
    measurements_.lend_imu(sample);
  }

  FrameReport process(const StereoFrame& frame) {
    auto& times_ns = measurements_.times_ns;
    expects(times_ns.empty() || frame.time_ns > times_ns.back(),
            "SlamSystem::process: stamps of frames must increase");
    FrameReport report;
    {
      const StageScope scope(result_.timing, "frame");
      times_ns.push_back(frame.time_ns);
      report = see(frame);
    }
    result_.series.frame_ms.push_back(result_.timing.values_ms("frame").back());
    result_.series.memory_mb.push_back(static_cast<float>(present_memory_mb()));
    return report;
  }

  SlamResult finish();

  FrameObserver observer;
  WindowObserver window_observer;

 private:
  FrameReport see(const StereoFrame& frame) {
    vo::VoOutput seen;
    {
      const StageScope scope(result_.timing, "front end");
      seen = odometry_.process(frame, predict(frame.time_ns));
    }
    count(frame, seen);
    if (observer) observer(frame, seen);
    const bool vision = seen.motion.valid;
    if (vision) measurements_.odometry.push_back(seen.motion);
    for (const RelativeMotion& skip : seen.skip_motions) {
      if (skip.valid) measurements_.skips.push_back(skip);
    }
    if (loops_) recognise(frame, seen);
    if (inertial_ && options_.system.online) {
      const StageScope scope(result_.timing, "sliding window");
      online_.update(measurements_, [this] { return seen_disparity_offset(); });
    }
    if (window_observer && online_.started()) window_observer(online_.window().graph());
    const auto index = static_cast<std::uint32_t>(measurements_.times_ns.size() - 1);
    map_sampler_.add(frame, index, seen, result_.map);
    return {seen.motion.inliers, vision};
  }

  void recognise(const StereoFrame& frame, const vo::VoOutput& seen) {
    const StageScope scope(result_.timing, "loops");
    for (const RelativeMotion& loop : loops_->process(frame, seen, odometry_.disparity_offset())) {
      measurements_.skips.push_back(loop);
      ++result_.counters.loop_edges;
    }
  }

  void count(const StereoFrame& frame, const vo::VoOutput& seen) {
    Counters& counters = result_.counters;
    ++counters.frames;
    const bool first = counters.frames == 1;
    if (!frame.complete()) ++counters.frames_missing;
    if (frame.complete() && !first && !seen.motion.valid) ++counters.vo_failures;
    counters.skip_edges += seen.skip_motions.size();
    result_.series.inliers.push_back(static_cast<std::uint16_t>(
        std::clamp(seen.motion.valid ? seen.motion.inliers : 0, 0, 65535)));
  }

  /// The gyro knows how far the body has turned since the last good frame.
  std::optional<vo::MotionPrior> predict(std::int64_t time_ns) const {
    const auto anchor_ns = odometry_.anchor_time_ns();
    if (!inertial_ || !anchor_ns) return std::nullopt;
    if (to_seconds(time_ns - *anchor_ns) > kLongestPrediction_s) return std::nullopt;
    const double time_offset_s = online_.started() ? online_.window().globals().time_offset_s
                                                   : options_.system.time_offset_s;
    const ImuMotion motion =
        imu::preintegrate(measurements_.readings(), *anchor_ns, time_ns, present_bias(),
                          measurements_.imu_noise, time_offset_s, options_.preintegration);
    if (!motion.valid) return std::nullopt;
    return vo::MotionPrior{motion.dR, std::nullopt, foretold(motion, *anchor_ns)};
  }

  /// The translation only where the window has a velocity for its start.
  vo::ForetoldMotion foretold(const ImuMotion& motion, std::int64_t anchor_ns) const {
    const double bias_sigma =
        online_.started() ? kKnownGyroBias : measurements_.imu_noise.gyro_bias_sigma;
    const double noise = motion.covariance.topLeftCorner<3, 3>().trace() / 3.0;
    vo::ForetoldMotion result;
    result.R_body0_body1 = motion.dR;
    result.sigma_rad = std::sqrt(std::pow(bias_sigma * motion.dt_s, 2) +
                                 std::pow(kGyroScale * motion.dR.log().norm(), 2) + noise);
    if (!online_.started() || online_.window().newest().time_ns != anchor_ns) return result;
    const lie::SE3d& T_world_body0 = online_.window().newest().nav.T_world_body;
    result.p_body0_body1 =
        T_world_body0.inverse() * online_.foretell(motion).nav.T_world_body.translation();
    result.sigma_m =
        kKnownVelocity * motion.dt_s + 0.5 * kKnownAcceleration * motion.dt_s * motion.dt_s;
    return result;
  }

  /// The window's; before it has started what the correction believes, or zero.
  ImuBias present_bias() const {
    if (online_.started() || !inertial_front_end_) return online_.bias();
    return inertial_front_end_->bias();
  }

  /// Moves all motions to the disparity offset that vision alone found. The odometry's own
  /// trajectory gains from it; the graph refines it.
  Estimate correct_disparity_offset() {
    if (!options_.pgo.estimate_disparity_offset) return {};
    const Estimate estimate = seen_disparity_offset();
    for (auto* motions : {&measurements_.odometry, &measurements_.skips}) {
      for (RelativeMotion& motion : *motions) {
        motion = vo::with_disparity_offset(motion, estimate.value);
      }
    }
    return estimate;
  }

  Estimate seen_disparity_offset() const {
    const auto estimate = odometry_.disparity_offset_estimate();
    return {estimate.offset_px, estimate.sigma_px};
  }

  SlamOptions options_;
  StereoCamera camera_;
  vo::VisualOdometry odometry_;
  OnlineEstimator online_;
  std::optional<InertialFrontEnd> inertial_front_end_;  ///< empty: raw readings
  std::optional<imu::VibrationMeter> vibration_;        ///< of raw readings; empty: off
  std::optional<vo::LoopCloser> loops_;                 ///< empty: off
  MapSampler map_sampler_;
  Measurements measurements_;
  bool inertial_;
  SlamResult result_;
};

namespace {

/// Lays the odometry's chain onto the first pose of the graph.
Trajectory onto_first_pose(const Trajectory& chain, const lie::SE3d& T_world_body0) {
  Trajectory result;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    result.add(chain.times_ns[i], T_world_body0 * chain.poses[i]);
  }
  return result;
}

}  // namespace

SlamResult SlamSystem::State::finish() {
  if (measurements_.odometry.empty() && !inertial_) {
    throw InputError(
        "not a single motion could be measured in the images; look at them with `imslam check`",
        ExitCode::kTrackingLost);
  }
  BatchEstimate batch;
  {
    const StageScope scope(result_.timing, "batch graph");
    const Estimate offset = correct_disparity_offset();
    batch = estimate_batch(measurements_, offset, options_);
  }
  for (const pgo::State& state : batch.graph.states) {
    result_.graph.add(state.time_ns, state.nav.T_world_body);
  }
  result_.vo_only =
      onto_first_pose(chain_odometry(measurements_).trajectory, result_.graph.poses.front());
  result_.online = online_.trajectory();
  for (const bool covered : batch.covered) {
    result_.series.degraded.push_back(covered ? 0 : 1);
    if (!covered) ++result_.counters.frames_degraded;
  }
  result_.tracking_lost = 2 * result_.counters.frames_degraded > result_.counters.frames;
  result_.series.position_sigma_m = std::move(batch.position_sigma_m);
  result_.series.imu_gap.assign(batch.imu_gap.begin(), batch.imu_gap.end());
  result_.series.conflict.assign(batch.conflict.begin(), batch.conflict.end());
  result_.counters.imu_gaps =
      static_cast<std::size_t>(std::count(batch.imu_gap.begin(), batch.imu_gap.end(), true));
  result_.graph_data = std::move(batch.graph);
  result_.graph_options = batch.graph_options;
  result_.solve = batch.report;
  result_.inertial = batch.inertial;
  result_.disparity_offset_px = batch.disparity_offset_px;
  result_.focal_error = batch.focal_error;
  result_.time_offset_s = batch.time_offset_s;
  result_.camera_rotation = batch.camera_rotation;
  result_.gyro_shape = batch.gyro_shape;
  result_.gravity_m_s2 = options_.pgo.gravity_magnitude;
  result_.warnings = std::move(batch.warnings);
  if (inertial_) {
    const auto doubts = calibration_doubts(measurements_, camera_);
    result_.warnings.insert(result_.warnings.end(), doubts.begin(), doubts.end());
  }
  return std::move(result_);
}

SlamSystem::SlamSystem(const SlamOptions& options,
                       const StereoCamera& camera,
                       const std::optional<ImuNoise>& imu_noise,
                       const Networks* networks,
                       const DeviceCalibration& device,
                       FrameLoader load)
    : state_(std::make_unique<State>(
          with_device(options, device),
          calibrated(camera, device),
          imu_noise,
          make_front_end(options, calibrated(camera, device), networks, device),
          std::move(load))) {}

SlamSystem::~SlamSystem() = default;

void SlamSystem::add_imu(const ImuSample& sample) { state_->add_imu(sample); }

void SlamSystem::add_earlier_imu(const ImuSample& sample) { state_->add_earlier_imu(sample); }

SlamSystem::FrameReport SlamSystem::process(const StereoFrame& frame) {
  return state_->process(frame);
}

void SlamSystem::observe(FrameObserver observer) { state_->observer = std::move(observer); }

void SlamSystem::observe_window(WindowObserver observer) {
  state_->window_observer = std::move(observer);
}

SlamResult SlamSystem::finish() { return state_->finish(); }

}  // namespace imslam::system

#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "pgo/sliding_window.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/trajectory.hpp"
#include "slam/system/measurements.hpp"
#include "slam/system/slam_options.hpp"
#include "slam/system/slam_result.hpp"

namespace imslam::system {

/// The estimate while frames come in: a sliding window with a marginal prior.
///
/// It starts once vision and IMU allow an initialisation; the frames before then get the states of
/// that moment. Visual-inertial only: without an IMU the odometry is all there is to know.
class OnlineEstimator {
 public:
  explicit OnlineEstimator(const SlamOptions& options) : options_(options) {}

  /// Takes in the newest frame: the last of `measurements`. Its IMU samples must be there.
  /// `disparity_offset` tells what vision knows of the rectification by now, if asked.
  void update(const Measurements& measurements, const std::function<Estimate()>& disparity_offset);

  /// What was known at each frame; empty before the start.
  const Trajectory& trajectory() const { return trajectory_; }

  bool started() const { return window_.has_value(); }
  const pgo::SlidingWindow& window() const { return *window_; }  ///< once started
  /// The newest bias; zero before the start.
  ImuBias bias() const { return window_ ? window_->newest().bias : ImuBias(); }
  /// The state at the end of an IMU motion that starts at the newest one. Only once started.
  pgo::State foretell(const ImuMotion& motion) const;

 private:
  void try_to_start(const Measurements& measurements, const Estimate& disparity_offset);
  /// Number in the window of a frame, negative for those before its start.
  int number_of(std::size_t frame) const {
    return static_cast<int>(frame) - static_cast<int>(first_frame_);
  }
  void add_newest(const Measurements& measurements);
  /// Whether the gyro says that the newest motion is not the body's; `guess`: the newest state as
  /// the IMU has it.
  bool refuses(const RelativeMotion& motion,
               int from,
               const pgo::State& guess,
               const ImuMotion& imu_motion);

  const SlamOptions options_;
  std::optional<pgo::SlidingWindow> window_;
  Trajectory trajectory_;
  std::size_t next_try_ = 0;     ///< number of frames at which a start is tried again
  std::size_t first_frame_ = 0;  ///< where the window started
  int seen_ = 0;                 ///< the newest state that vision reached
  /// Since when vision and gyro have contradicted each other, if they do.
  std::optional<std::int64_t> contradicted_ns_;
};

}  // namespace imslam::system

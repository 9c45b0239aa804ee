#pragma once

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
  /// `disparity_offset` is what vision knows of the rectification by now.
  void update(const Measurements& measurements, const Estimate& disparity_offset);

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
  std::size_t next_try_ = 0;    ///< number of frames at which a start is tried again
  std::int64_t agreed_ns_ = 0;  ///< when vision and gyro last said the same
};

}  // namespace imslam::system

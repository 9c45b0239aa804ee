#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "pgo/pose_velocity_graph.hpp"
#include "slam/sensors/calibration.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/stereo.hpp"
#include "slam/system/front_end.hpp"
#include "slam/system/slam_options.hpp"
#include "slam/system/slam_result.hpp"
#include "vo_net/visual_odometry.hpp"

namespace imslam::system {

using FrameObserver = std::function<void(const StereoFrame& frame, const vo::VoOutput& seen)>;

using WindowObserver = std::function<void(const pgo::PoseVelocityGraph& window)>;

/// The SLAM loop: frames and inertial samples in, states out. Knows no files.
///
///   per frame   front end -> relative motions;  IMU -> preintegrated motion;  sliding window
///   at the end  all motions -> one graph, solved to convergence
///
/// Samples up to a frame's stamp (and a little more, for the time offset) are added before it.
class SlamSystem {
 public:
  /// `imu_noise` empty: there is no IMU, the graph is visual only. `camera`: as stated; `device`:
  /// what is known beyond that. `networks`: see make_front_end(), which throws. `load`: gets the
  /// images of frames that come unread, where a recording stands in for the matcher.
  SlamSystem(const SlamOptions& options,
             const StereoCamera& camera,
             const std::optional<ImuNoise>& imu_noise,
             const Networks* networks = nullptr,
             const DeviceCalibration& device = {},
             FrameLoader load = {});
  ~SlamSystem();
  SlamSystem(const SlamSystem&) = delete;
  SlamSystem& operator=(const SlamSystem&) = delete;

  /// Samples come in order of time; one that does not is counted and left out. Each stays where it
  /// is, unchanged, until finish() has returned: those that lie one behind the other in memory, as
  /// in the vector of a sequence, are not copied.
  void add_imu(const ImuSample& sample);
  /// A reading from long before the first frame: the correction learns about the sensor from it,
  /// nothing else does. In order of time, before all others.
  void add_earlier_imu(const ImuSample& sample);

  /// What is known about a frame as soon as it was seen.
  struct FrameReport {
    int inliers = 0;
    bool vision = false;  ///< its motion was measured
  };
  FrameReport process(const StereoFrame& frame);

  /// Tells somebody what the odometry saw in each frame.
  void observe(FrameObserver observer);
  /// And what the sliding window made of it, from when it has started; after the frame's observer.
  void observe_window(WindowObserver observer);

  /// Solves the graph over everything seen so far. Call it once, at the end.
  SlamResult finish();

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace imslam::system

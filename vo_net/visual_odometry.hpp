#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/base/config.hpp"
#include "slam/sensors/calibration.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/sensors/stereo.hpp"
#include "vo_net/klt_matcher.hpp"
#include "vo_net/matcher.hpp"
#include "vo_net/pose_layer.hpp"

namespace imslam::vo {

struct VoOptions {
  KltOptions klt;
  PoseLayerOptions pose;
  double covariance_inflation = 1.0;  ///< [1] on standard deviations, for errors points share

  void describe(Config& config);
  void validate() const;
};

/// Where the body is expected to have gone since the last complete frame. Only the start of the
/// search; the result does not lean on it.
struct MotionPrior {
  lie::SO3d R_body0_body1;                       ///< e.g. from the gyro
  std::optional<Eigen::Vector3d> p_body0_body1;  ///< [m]; unknown: as fast as before
};

struct VoTimings {
  double match_s = 0.0;
  double solve_s = 0.0;
};

/// What one frame says.
struct VoOutput {
  RelativeMotion motion;  ///< from the last complete frame to this one (see time0_ns)
  std::vector<RelativeMotion> skip_motions;  ///< from older frames to this one
  std::vector<StereoPoint> points;           ///< of this frame
  PoseLayerResult pose;                      ///< behind `motion`; index as correspondences
  Correspondences correspondences;
  int tracked = 0;
  VoTimings timings;
};

/// Motion from stereo frames, one relative pose per frame.
///
/// Frames with a missing image give an invalid motion; the next complete frame is then matched with
/// the last complete one and its motion spans the gap.
class VisualOdometry {
 public:
  VisualOdometry(const VoOptions& options, const StereoCamera& camera);
  /// With another matcher than the classical one.
  VisualOdometry(const VoOptions& options,
                 const StereoCamera& camera,
                 std::unique_ptr<Matcher> matcher);
  ~VisualOdometry();

  VoOutput process(const StereoFrame& frame, const std::optional<MotionPrior>& prior = {});

  /// The constant disparity offset [px] that measurements are corrected with from now on.
  void set_disparity_offset(double offset_px) { disparity_offset_ = offset_px; }
  double disparity_offset() const { return disparity_offset_; }

 private:
  lie::SE3d predict(std::int64_t time_ns, const std::optional<MotionPrior>& prior) const;
  RelativeMotion to_motion(const PoseLayerResult& pose,
                           std::int64_t time0_ns,
                           std::int64_t time1_ns) const;
  void add_skip_motions(const MatchResult& match,
                        const VoOutput& output,
                        std::int64_t time_ns,
                        std::vector<RelativeMotion>& motions) const;

  VoOptions options_;
  StereoCamera camera_;
  std::unique_ptr<Matcher> matcher_;
  double disparity_offset_ = 0.0;

  std::int64_t last_time_ns_ = 0;  ///< of the last complete frame
  bool has_frame_ = false;
  Eigen::Matrix<double, 6, 1> twist_ = Eigen::Matrix<double, 6, 1>::Zero();  ///< [m/s rad/s]
};

}  // namespace imslam::vo

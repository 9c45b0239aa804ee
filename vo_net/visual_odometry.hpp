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
#include "vo_net/disparity_offset.hpp"
#include "vo_net/klt_matcher.hpp"
#include "vo_net/learned_options.hpp"
#include "vo_net/matcher.hpp"
#include "vo_net/motion_noise.hpp"
#include "vo_net/pose_layer.hpp"
#include "vo_net/regression_odometry.hpp"

namespace imslam::vo {

struct VoOptions {
  KltOptions klt;
  LearnedMatcherOptions learned;
  std::string head = "geometric";  ///< motion from matches: geometric, regression
  PoseLayerOptions pose;           ///< of the geometric head; its limits hold for both
  RegressionOptions regression;
  DisparityOffsetOptions offset;
  /// [1] share of the matching variance that all points have in common (lens model, blur): it does
  /// not average out, so n points count as n / (1 + shared_error n). Of the geometric head.
  double shared_error = 0.15;
  std::string motion_noise;  ///< file of a MotionNoise that corrects covariances; empty: none

  void describe(Config& config);
  void validate() const;
};

/// Where the body is expected to have gone since VisualOdometry::anchor_time_ns(). Only the start
/// of the search, and what tells the scene from what moves in it (see solve_pose()); the result
/// does not lean on it.
struct MotionPrior {
  lie::SO3d R_body0_body1;                       ///< e.g. from the gyro
  std::optional<Eigen::Vector3d> p_body0_body1;  ///< [m]; unknown: as fast as before
  std::optional<ForetoldMotion> foretold;        ///< where it is sure enough to tell points apart
};

struct VoTimings {
  double match_s = 0.0;
  double solve_s = 0.0;
};

/// What one frame says.
struct VoOutput {
  RelativeMotion motion;                     ///< from the last good frame (time0_ns) to this one
  std::vector<RelativeMotion> skip_motions;  ///< from older frames to this one
  std::vector<StereoPoint> points;           ///< of this frame
  PoseLayerResult pose;                      ///< behind `motion`; index as correspondences
  Correspondences correspondences;
  MatchSearch search;  ///< behind them
  int tracked = 0;
  VoTimings timings;
};

/// Motion from stereo frames, one relative pose per frame.
///
/// A frame with a missing image, or with far fewer points than the one before (black, covered,
/// damaged), gives an invalid motion and is left out: the next frame is matched with the last good
/// one and its motion spans the gap. A frame full of points that has nothing in common with the
/// last one (a cut) becomes the new beginning. The longer nothing fits, the fewer points that
/// takes.
class VisualOdometry {
 public:
  /// Throws InputError(kModel) if options.head = regression and there are no weights.
  VisualOdometry(const VoOptions& options, const StereoCamera& camera);
  /// With another matcher than the classical one.
  VisualOdometry(const VoOptions& options,
                 const StereoCamera& camera,
                 std::unique_ptr<Matcher> matcher);
  /// And with a pose head, for options.head = regression, and the noise of motions; both may be
  /// null: then the options say whether there are any.
  VisualOdometry(const VoOptions& options,
                 const StereoCamera& camera,
                 std::unique_ptr<Matcher> matcher,
                 std::shared_ptr<const PoseHead<float>> pose_head,
                 std::shared_ptr<const MotionNoise<float>> motion_noise = nullptr);
  ~VisualOdometry();

  VoOutput process(const StereoFrame& frame, const std::optional<MotionPrior>& prior = {});

  /// Stamp of the frame that the next motion will start from; empty before the first good frame.
  std::optional<std::int64_t> anchor_time_ns() const;

  /// The constant disparity offset [px] that measurements are corrected with from now on.
  void set_disparity_offset(double offset_px) { disparity_offset_ = offset_px; }
  double disparity_offset() const { return disparity_offset_; }

  /// What all frames so far say about it. Where it differs from the value a motion was computed
  /// with, the motion can be corrected afterwards: T Exp(J_disparity_offset difference).
  DisparityOffsetEstimate disparity_offset_estimate() const { return offset_.estimate(); }

 private:
  lie::SE3d predict(std::int64_t time_ns, const std::optional<MotionPrior>& prior) const;
  PoseLayerResult motion_of(const Correspondences& correspondences,
                            const lie::SE3d& start,
                            const std::optional<ForetoldMotion>& foretold) const;
  void solve(const MatchResult& match,
             const lie::SE3d& predicted,
             const std::optional<ForetoldMotion>& foretold,
             VoOutput& output);
  bool is_poor(std::size_t points) const;
  RelativeMotion to_motion(const PoseLayerResult& pose,
                           const Correspondences& correspondences,
                           std::int64_t time0_ns,
                           std::int64_t time1_ns) const;
  void add_skip_motions(const MatchResult& match,
                        const VoOutput& output,
                        std::int64_t time_ns,
                        std::vector<RelativeMotion>& motions) const;

  VoOptions options_;
  StereoCamera camera_;
  std::unique_ptr<Matcher> matcher_;
  std::optional<RegressionHead> regression_;                ///< none: the geometric head
  std::shared_ptr<const MotionNoise<float>> motion_noise_;  ///< null: covariances as they are
  DisparityOffsetEstimator offset_;
  double disparity_offset_ = 0.0;

  std::int64_t anchor_time_ns_ = 0;  ///< of the last good frame
  std::size_t anchor_points_ = 0;    ///< seen in it; 0: there is none
  double expected_points_ = 0.0;     ///< in a good frame, as far as is still known
  Eigen::Matrix<double, 6, 1> twist_ = Eigen::Matrix<double, 6, 1>::Zero();  ///< [m/s rad/s]
};

}  // namespace imslam::vo

#include "vo_net/visual_odometry.hpp"

#include <chrono>

#include "slam/base/error.hpp"
#include "slam/base/time.hpp"
#include "vo_net/options_check.hpp"
#include "vo_net/pose_head_weights.hpp"

namespace imslam::vo {
namespace {

constexpr double kPoorShare = 0.3;  // of the last good frame's points; fewer: the image is bad

constexpr double kFading = 0.8;  // of that number, per bad frame: a new view may hold fewer

class StopWatch {
 public:
  double seconds() {
    const auto now = std::chrono::steady_clock::now();
    const double passed = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return passed;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::vector<std::int64_t> outlier_tracks(const Correspondences& correspondences,
                                         const PoseLayerResult& pose) {
  std::vector<std::int64_t> ids;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    if (pose.is_inlier[i] == 0) ids.push_back(correspondences[i].track_id);
  }
  return ids;
}

}  // namespace

void VoOptions::describe(Config& config) {
  config.section("klt", klt);
  config.section("learned", learned);
  config.field("head", head, {"geometric", "regression"}, "motion from matches");
  config.section("pose", pose);
  config.section("regression", regression);
  config.section("offset", offset);
  config.field("shared_error", shared_error,
               "share of the matching variance that all points have in common [1]");
  config.field("motion_noise", motion_noise,
               "file of a network that corrects covariances; empty: none");
}

void VoOptions::validate() const {
  klt.validate();
  learned.validate();
  pose.validate();
  regression.validate();
  offset.validate();
  require(shared_error >= 0.0 && shared_error <= 1.0, "vo.shared_error", shared_error, "0 .. 1");
}

VisualOdometry::VisualOdometry(const VoOptions& options, const StereoCamera& camera)
    : VisualOdometry(options, camera, std::make_unique<KltMatcher>(options.klt, camera)) {}

VisualOdometry::VisualOdometry(const VoOptions& options,
                               const StereoCamera& camera,
                               std::unique_ptr<Matcher> matcher)
    : VisualOdometry(options, camera, std::move(matcher), nullptr, nullptr) {}

VisualOdometry::VisualOdometry(const VoOptions& options,
                               const StereoCamera& camera,
                               std::unique_ptr<Matcher> matcher,
                               std::shared_ptr<const PoseHead<float>> pose_head,
                               std::shared_ptr<const MotionNoise<float>> motion_noise)
    : options_(options),
      camera_(camera),
      matcher_(std::move(matcher)),
      motion_noise_(std::move(motion_noise)),
      offset_(options.offset) {
  options_.validate();
  if (!motion_noise_ && !options.motion_noise.empty()) {
    motion_noise_ = load_motion_noise(options.motion_noise).network;
  }
  expects(matcher_ != nullptr, "VisualOdometry: needs a matcher");
  if (options_.head != "regression") return;
  if (!pose_head) pose_head = load_pose_head(options_.regression.weights).network;
  regression_.emplace(options_.regression, std::move(pose_head));
}

VisualOdometry::~VisualOdometry() = default;

lie::SE3d VisualOdometry::predict(std::int64_t time_ns,
                                  const std::optional<MotionPrior>& prior) const {
  const lie::SE3d steady = lie::SE3d::exp(twist_ * to_seconds(time_ns - anchor_time_ns_));
  if (!prior) return steady;
  return {prior->R_body0_body1, prior->p_body0_body1.value_or(steady.translation())};
}

RelativeMotion VisualOdometry::to_motion(const PoseLayerResult& pose,
                                         const Correspondences& correspondences,
                                         std::int64_t time0_ns,
                                         std::int64_t time1_ns) const {
  RelativeMotion motion;
  motion.time0_ns = time0_ns;
  motion.time1_ns = time1_ns;
  motion.disparity_offset = pose.disparity_offset;
  motion.inliers = pose.inliers;
  motion.valid = pose.valid;
  if (!pose.valid) return motion;
  motion.T_body0_body1 = pose.T_body0_body1;
  // What a network says of its errors is the whole; the pose layer takes points for independent.
  const double shared = regression_ ? 0.0 : options_.shared_error;
  motion.covariance = pose.covariance * (1.0 + shared * static_cast<double>(pose.inliers));
  if (motion_noise_) {
    const auto features = motion_noise_features(pose, correspondences, camera_);
    const Eigen::Matrix<double, 6, 1> factors = noise_factors(*motion_noise_, features);
    motion.covariance = factors.asDiagonal() * motion.covariance * factors.asDiagonal();
  }
  motion.J_disparity_offset = pose.J_disparity_offset;
  motion.J_focal_error = pose.J_focal_error;
  return motion;
}

void VisualOdometry::add_skip_motions(const MatchResult& match,
                                      const VoOutput& output,
                                      std::int64_t time_ns,
                                      std::vector<RelativeMotion>& motions) const {
  for (const FrameMatch& earlier : match.earlier) {
    const double ratio = to_seconds(time_ns - earlier.time0_ns) /
                         std::max(1e-3, to_seconds(time_ns - output.motion.time0_ns));
    const lie::SE3d start = lie::SE3d::exp(output.motion.T_body0_body1.log() * ratio);
    const PoseLayerResult pose = motion_of(earlier.correspondences, start, {});
    if (!pose.valid) continue;
    motions.push_back(to_motion(pose, earlier.correspondences, earlier.time0_ns, time_ns));
  }
}

VoOutput VisualOdometry::process(const StereoFrame& frame,
                                 const std::optional<MotionPrior>& prior) {
  VoOutput output;
  output.motion.time0_ns = anchor_time_ns_;
  output.motion.time1_ns = frame.time_ns;
  output.motion.disparity_offset = disparity_offset_;
  if (!frame.complete()) return output;

  const bool has_anchor = anchor_points_ > 0;
  StopWatch watch;
  const lie::SE3d predicted = has_anchor ? predict(frame.time_ns, prior) : lie::SE3d();
  MatchResult match = matcher_->match(frame, predicted);
  output.timings.match_s = watch.seconds();
  if (has_anchor) solve(match, predicted, prior ? prior->foretold : std::nullopt, output);
  output.timings.solve_s = watch.seconds();
  output.points = std::move(match.points);
  output.search = match.previous.search;
  output.correspondences = std::move(match.previous.correspondences);
  if (!output.motion.valid && is_poor(output.points.size())) {
    matcher_->forget_newest();
    expected_points_ *= kFading;
    return output;
  }
  anchor_time_ns_ = frame.time_ns;
  anchor_points_ = output.points.size();
  expected_points_ = static_cast<double>(anchor_points_);
  return output;
}

PoseLayerResult VisualOdometry::motion_of(const Correspondences& correspondences,
                                          const lie::SE3d& start,
                                          const std::optional<ForetoldMotion>& foretold) const {
  if (regression_) {
    return regression_->solve(correspondences, camera_, options_.pose, disparity_offset_);
  }
  return solve_pose(correspondences, camera_, options_.pose, start, disparity_offset_, foretold);
}

void VisualOdometry::solve(const MatchResult& match,
                           const lie::SE3d& predicted,
                           const std::optional<ForetoldMotion>& foretold,
                           VoOutput& output) {
  const Correspondences& correspondences = match.previous.correspondences;
  const std::int64_t time_ns = output.motion.time1_ns;
  output.tracked = static_cast<int>(correspondences.size());
  output.pose = motion_of(correspondences, predicted, foretold);
  output.motion = to_motion(output.pose, correspondences, anchor_time_ns_, time_ns);
  if (!output.motion.valid) return;
  offset_.add(output.pose);
  matcher_->drop(outlier_tracks(correspondences, output.pose));
  twist_ = output.motion.T_body0_body1.log() / to_seconds(time_ns - anchor_time_ns_);
  add_skip_motions(match, output, time_ns, output.skip_motions);
}

bool VisualOdometry::is_poor(std::size_t points) const {
  const auto needed = static_cast<std::size_t>(options_.pose.min_inliers);
  return points < needed || static_cast<double>(points) < kPoorShare * expected_points_;
}

std::optional<std::int64_t> VisualOdometry::anchor_time_ns() const {
  if (anchor_points_ == 0) return std::nullopt;
  return anchor_time_ns_;
}

}  // namespace imslam::vo

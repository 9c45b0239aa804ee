#include "vo_net/visual_odometry.hpp"

#include <chrono>

#include "slam/base/error.hpp"
#include "slam/base/time.hpp"
#include "vo_net/options_check.hpp"

namespace imslam::vo {
namespace {

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
  config.section("pose", pose);
  config.field("covariance_inflation", covariance_inflation,
               "factor on the standard deviations of the motion, for errors that points share");
}

void VoOptions::validate() const {
  klt.validate();
  pose.validate();
  require(covariance_inflation > 0.0, "vo.covariance_inflation", covariance_inflation, "> 0");
}

VisualOdometry::VisualOdometry(const VoOptions& options, const StereoCamera& camera)
    : VisualOdometry(options, camera, std::make_unique<KltMatcher>(options.klt, camera)) {}

VisualOdometry::VisualOdometry(const VoOptions& options,
                               const StereoCamera& camera,
                               std::unique_ptr<Matcher> matcher)
    : options_(options), camera_(camera), matcher_(std::move(matcher)) {
  options_.validate();
  expects(matcher_ != nullptr, "VisualOdometry: needs a matcher");
}

VisualOdometry::~VisualOdometry() = default;

lie::SE3d VisualOdometry::predict(std::int64_t time_ns,
                                  const std::optional<MotionPrior>& prior) const {
  const lie::SE3d steady = lie::SE3d::exp(twist_ * to_seconds(time_ns - last_time_ns_));
  if (!prior) return steady;
  return {prior->R_body0_body1, prior->p_body0_body1.value_or(steady.translation())};
}

RelativeMotion VisualOdometry::to_motion(const PoseLayerResult& pose,
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
  motion.covariance =
      pose.covariance * (options_.covariance_inflation * options_.covariance_inflation);
  motion.J_disparity_offset = pose.J_disparity_offset;
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
    const PoseLayerResult pose =
        solve_pose(earlier.correspondences, camera_, options_.pose, start, disparity_offset_);
    if (pose.valid) motions.push_back(to_motion(pose, earlier.time0_ns, time_ns));
  }
}

VoOutput VisualOdometry::process(const StereoFrame& frame,
                                 const std::optional<MotionPrior>& prior) {
  VoOutput output;
  output.motion.time0_ns = last_time_ns_;
  output.motion.time1_ns = frame.time_ns;
  output.motion.disparity_offset = disparity_offset_;
  if (!frame.complete()) return output;

  StopWatch watch;
  const lie::SE3d predicted = has_frame_ ? predict(frame.time_ns, prior) : lie::SE3d();
  MatchResult match = matcher_->match(frame, predicted);
  output.timings.match_s = watch.seconds();
  if (has_frame_) {
    const Correspondences& correspondences = match.previous.correspondences;
    output.tracked = static_cast<int>(correspondences.size());
    output.pose = solve_pose(correspondences, camera_, options_.pose, predicted, disparity_offset_);
    output.motion = to_motion(output.pose, last_time_ns_, frame.time_ns);
    if (output.motion.valid) {
      matcher_->drop(outlier_tracks(correspondences, output.pose));
      twist_ = output.motion.T_body0_body1.log() / to_seconds(frame.time_ns - last_time_ns_);
      add_skip_motions(match, output, frame.time_ns, output.skip_motions);
    }
    output.timings.solve_s = watch.seconds();
  }
  output.points = std::move(match.points);
  output.correspondences = std::move(match.previous.correspondences);
  last_time_ns_ = frame.time_ns;
  has_frame_ = true;
  return output;
}

}  // namespace imslam::vo

#include "vo_net/loop_closer.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/base/time.hpp"

namespace imslam::vo {
namespace {

// What a body does while nothing sees it.
constexpr double kUnseenSpeed_m_s = 1.0;
constexpr double kUnseenRate_rad_s = 0.5;

double median_disparity(const std::vector<StereoPoint>& points) {
  std::vector<double> values;
  for (const StereoPoint& point : points) values.push_back(std::max(0.1, point.disparity));
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

LoopCloser::LoopCloser(const LoopOptions& options,
                       const VoOptions& vo,
                       const StereoCamera& camera,
                       FrameLoader load)
    : options_(options),
      vo_(vo),
      camera_(camera),
      map_(options, camera),
      matcher_(options, vo, camera),
      load_(std::move(load)) {}

void LoopCloser::move(const lie::SE3d& T_body0_body1, const Matrix6& covariance) {
  T_map_body_ = T_map_body_ * T_body0_body1;
  map_.move(T_body0_body1, covariance);
  drift_.translation += covariance.topLeftCorner<3, 3>().trace() / 3.0;
  drift_.rotation += covariance.bottomRightCorner<3, 3>().trace() / 3.0;
}

/// Nothing is known about the time since the last pose.
void LoopCloser::bridge(std::int64_t time_ns) {
  const double dt_s = to_seconds(time_ns - *time_ns_);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Eigen::Vector3d::Constant(kUnseenSpeed_m_s * dt_s),
      Eigen::Vector3d::Constant(kUnseenRate_rad_s * dt_s);
  move(lie::SE3d(), sigma.cwiseAbs2().asDiagonal());
}

void LoopCloser::advance(const RelativeMotion& motion) {
  if (time_ns_ && motion.time0_ns > *time_ns_) bridge(motion.time0_ns);
  move(motion.T_body0_body1, options_.drift_factor * options_.drift_factor * motion.covariance);
  time_ns_ = motion.time1_ns;
}

/// Of the motion since `keyframe`, by way of the view that was recognised last: what is known since
/// that one, and the odometry's drift between the two views.
LoopCloser::Matrix6 LoopCloser::covariance_by_last_match(const Keyframe& keyframe,
                                                         const lie::SE3d& T_body0_body1) {
  const Keyframe* last = matched_ns_ ? map_.at(*matched_ns_) : nullptr;
  if (last == nullptr) return keyframe.covariance;
  const double rotation = std::abs(keyframe.drift.rotation - last->drift.rotation);
  const double lever_sq = T_body0_body1.translation().squaredNorm();
  Matrix6 covariance = last->covariance;
  covariance.diagonal().head<3>().array() +=
      std::abs(keyframe.drift.translation - last->drift.translation) + rotation * lever_sq;
  covariance.diagonal().tail<3>().array() += rotation;
  return covariance;
}

/// How far a point may lie from where it is expected, in pixels.
double LoopCloser::search_px(const Keyframe& keyframe, const Matrix6& covariance) const {
  const double sigma_t = std::sqrt(covariance.diagonal().head<3>().maxCoeff());
  const double sigma_r = std::sqrt(covariance.diagonal().tail<3>().maxCoeff());
  return std::hypot(camera_.fx * sigma_r, keyframe.median_disparity / camera_.baseline_m * sigma_t);
}

std::optional<PredictedMotion> LoopCloser::predict(const Keyframe& keyframe) {
  const lie::SE3d T_map_body0 = keyframe.T_map_left * camera_.T_body_left.inverse();
  PredictedMotion predicted;
  predicted.T_body0_body1 = T_map_body0.inverse() * T_map_body_;
  predicted.covariance = keyframe.covariance;
  const Matrix6 by_match = covariance_by_last_match(keyframe, predicted.T_body0_body1);
  // What is known of a view by the odometry alone is not of a pose that has jumped since.
  const bool jumped = corrected_ns_ > keyframe.time_ns && matched_ns_ != keyframe.time_ns;
  if (jumped || search_px(keyframe, by_match) < search_px(keyframe, keyframe.covariance)) {
    predicted.covariance = by_match;
  }
  const double sigma_px = search_px(keyframe, predicted.covariance);
  if (!(3.0 * sigma_px <= options_.max_search * camera_.width)) return std::nullopt;
  return predicted;
}

/// Kalman update of the motion since that view, and with it of the pose in the map.
void LoopCloser::correct(std::int64_t keyframe_ns, const RelativeMotion& motion) {
  Keyframe* keyframe = map_.at(keyframe_ns);
  if (keyframe == nullptr) return;
  const lie::SE3d T_map_body0 = keyframe->T_map_left * camera_.T_body_left.inverse();
  const auto predicted = predict(*keyframe);
  const Matrix6 known = predicted ? predicted->covariance : keyframe->covariance;
  const Eigen::Matrix<double, 6, 1> innovation =
      (T_map_body_.inverse() * T_map_body0 * motion.T_body0_body1).log();
  const Eigen::LDLT<Matrix6> sum(known + motion.covariance);
  const Matrix6 gain = sum.solve(known).transpose();
  const Matrix6 rest = Matrix6::Identity() - gain;
  T_map_body_ = T_map_body_ * lie::SE3d::exp(gain * innovation);
  keyframe->covariance =
      rest * known * rest.transpose() + gain * motion.covariance * gain.transpose();
  matched_ns_ = keyframe_ns;
  corrected_ns_ = motion.time1_ns;
}

const StereoFrame& LoopCloser::with_images(const StereoFrame& frame) {
  if (!frame.unread) return frame;
  if (loaded_.time_ns == frame.time_ns && loaded_.complete()) return loaded_;
  expects(load_ != nullptr, "LoopCloser: frames that come unread need a loader");
  loaded_ = load_(frame.index);
  return loaded_;
}

std::vector<RelativeMotion> LoopCloser::recognise(const StereoFrame& frame,
                                                  double disparity_offset) {
  std::vector<RelativeMotion> motions;
  const auto candidates = map_.candidates(T_map_body_ * camera_.T_body_left, frame.time_ns);
  bool built = false;
  for (const KeyframeMap::Candidate& candidate : candidates) {
    const auto predicted = predict(*candidate.keyframe);
    if (!predicted) continue;
    if (!std::exchange(built, true)) {
      const StereoFrame& images = with_images(frame);
      if (!images.complete()) break;  // gone since it was first read
      view_.left.build(images.left, vo_.klt.levels, vo_.klt.smoothing);
      view_.right.build(images.right, vo_.klt.levels, vo_.klt.smoothing);
    }
    const auto motion =
        matcher_.match(*candidate.keyframe, view_, frame.time_ns, *predicted, disparity_offset);
    if (!motion) continue;
    correct(candidate.keyframe->time_ns, *motion);
    motions.push_back(*motion);
  }
  return motions;
}

void LoopCloser::keep(const StereoFrame& frame, const std::vector<StereoPoint>& points) {
  Keyframe keyframe;
  keyframe.time_ns = frame.time_ns;
  keyframe.T_map_left = T_map_body_ * camera_.T_body_left;
  keyframe.drift = drift_;
  keyframe.left = with_images(frame).left;
  if (keyframe.left.empty()) return;
  const auto most = static_cast<std::size_t>(options_.max_points);
  const std::size_t count = std::min(points.size(), most);
  keyframe.points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    keyframe.points.push_back(points[i * points.size() / count]);
  }
  keyframe.median_disparity = median_disparity(keyframe.points);
  map_.add(std::move(keyframe));
}

std::vector<RelativeMotion> LoopCloser::process(const StereoFrame& frame,
                                                const VoOutput& seen,
                                                double disparity_offset) {
  if (!frame.complete()) return {};
  const bool first = !time_ns_.has_value();
  if (first) {
    if (seen.points.size() < static_cast<std::size_t>(options_.min_inliers)) return {};
    time_ns_ = frame.time_ns;
  } else {
    if (!seen.motion.valid) return {};
    advance(seen.motion);
    if (++frames_since_search_ < options_.every) return {};
  }
  frames_since_search_ = 0;
  std::vector<RelativeMotion> motions = recognise(frame, disparity_offset);
  const bool worth = seen.points.size() >= static_cast<std::size_t>(options_.min_inliers);
  if (worth && map_.is_new_view(T_map_body_ * camera_.T_body_left)) keep(frame, seen.points);
  return motions;
}

}  // namespace imslam::vo

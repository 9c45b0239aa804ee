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
  const Matrix6 A = T_body0_body1.inverse().adjoint();
  covariance_ = A * covariance_ * A.transpose() + covariance;
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

std::optional<PredictedMotion> LoopCloser::predict(const Keyframe& keyframe) const {
  const lie::SE3d T_map_body0 = keyframe.T_map_left * camera_.T_body_left.inverse();
  PredictedMotion predicted;
  predicted.T_body0_body1 = T_map_body0.inverse() * T_map_body_;
  const Matrix6 A = predicted.T_body0_body1.inverse().adjoint();
  predicted.covariance = covariance_ + A * keyframe.covariance * A.transpose();
  const double sigma_t = std::sqrt(predicted.covariance.diagonal().head<3>().maxCoeff());
  const double sigma_r = std::sqrt(predicted.covariance.diagonal().tail<3>().maxCoeff());
  const double sigma_px =
      std::hypot(camera_.fx * sigma_r, keyframe.median_disparity / camera_.baseline_m * sigma_t);
  if (!(3.0 * sigma_px <= options_.max_search * camera_.width)) return std::nullopt;
  return predicted;
}

/// Kalman update of the pose in the map.
void LoopCloser::correct(const Keyframe& keyframe, const RelativeMotion& motion) {
  const lie::SE3d T_map_body0 = keyframe.T_map_left * camera_.T_body_left.inverse();
  const Matrix6 A = motion.T_body0_body1.inverse().adjoint();
  const Matrix6 noise = motion.covariance + A * keyframe.covariance * A.transpose();
  const Eigen::Matrix<double, 6, 1> innovation =
      (T_map_body_.inverse() * T_map_body0 * motion.T_body0_body1).log();
  const Eigen::LDLT<Matrix6> sum(covariance_ + noise);
  const Matrix6 gain = sum.solve(covariance_).transpose();
  const Matrix6 rest = Matrix6::Identity() - gain;
  T_map_body_ = T_map_body_ * lie::SE3d::exp(gain * innovation);
  covariance_ = rest * covariance_ * rest.transpose() + gain * noise * gain.transpose();
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
    correct(*candidate.keyframe, *motion);
    motions.push_back(*motion);
  }
  return motions;
}

void LoopCloser::keep(const StereoFrame& frame, const std::vector<StereoPoint>& points) {
  Keyframe keyframe;
  keyframe.time_ns = frame.time_ns;
  keyframe.T_map_left = T_map_body_ * camera_.T_body_left;
  keyframe.covariance = covariance_;
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

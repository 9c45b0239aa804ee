#include "vo_net/keyframe_comparison.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"
#include "vo_net/stereo_matcher.hpp"

namespace imslam::vo {
namespace {

constexpr double kMinDisparity = 0.1;  // [px] farther points are as good as at infinity
constexpr double kSureRadius = 6.0;    // [px] Lucas-Kanade reaches so far by itself
constexpr double kSearchSigmas = 3.0;  // the search covers so much of the prediction's error
constexpr int kSearchStep = 12;        // [px at the searched level] radius, at most
constexpr int kSearchWindow = 13;      // [px at the searched level]
constexpr int kCoarsestSearch = 3;     // pyramid level
constexpr std::size_t kScouts = 100;   // points that are searched for at first
constexpr int kMinScouts = 15;         // that must agree
constexpr double kScoutCorrelation = 0.7;
constexpr double kScoutSigma_px = 0.7;  // seen at half size
constexpr double kScoutShare = 0.4;     // of the scouts found that must agree
constexpr double kMatchShare = 0.5;     // of the final matches that must agree
constexpr int kGrid = 4;                // the image in kGrid x kGrid cells
constexpr int kMinCells = 6;            // that must hold an inlier
constexpr std::size_t kChunk = 16;      // points per parallel task

template <typename Body>
void parallel_chunks(std::size_t count, const Body& body) {
  parallel_for((count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    const std::size_t end = std::min(count, (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i) body(i);
  });
}

}  // namespace

KeyframeComparison::KeyframeComparison(const LoopOptions& options,
                                       const VoOptions& vo,
                                       const StereoCamera& camera,
                                       const Keyframe& keyframe,
                                       const CurrentView& view,
                                       double disparity_offset)
    : options_(options),
      vo_(vo),
      camera_(camera),
      keyframe_(keyframe),
      view_(view),
      offset_(disparity_offset) {
  then_.build(keyframe.left, vo.klt.levels, vo.klt.smoothing);
  align_.window = vo.klt.window;
  align_.smoothing = vo.klt.smoothing;
}

std::optional<KeyframeTarget> KeyframeComparison::target(const StereoPoint& point,
                                                         const lie::SE3d& T_left1_left0) const {
  const double d = std::max(point.disparity - offset_, kMinDisparity);
  const auto seen_now = [&](double du, double dv) -> Eigen::Vector3d {
    return T_left1_left0 * camera_.back_project({point.left.x() + du, point.left.y() + dv, d});
  };
  const Eigen::Vector3d p = seen_now(0.0, 0.0);
  if (!(p.z() > camera_.baseline_m)) return std::nullopt;
  const Eigen::Vector3d uvd = camera_.project(p);
  const double margin = 0.5 * align_.window;
  if (!uvd.allFinite() || uvd.x() < margin || uvd.y() < margin ||
      uvd.x() > camera_.width - 1 - margin || uvd.y() > camera_.height - 1 - margin) {
    return std::nullopt;
  }
  KeyframeTarget target;
  target.point = &point;
  target.disparity = uvd.z() + offset_;
  target.warp.center = point.left;
  target.warp.expected = uvd.head<2>();
  // The patch is taken for a piece of a plane parallel to the keyframe's image.
  target.warp.A_target_source.col(0) = (camera_.project(seen_now(1.0, 0.0)) - uvd).head<2>();
  target.warp.A_target_source.col(1) = (camera_.project(seen_now(0.0, 1.0)) - uvd).head<2>();
  return target;
}

std::vector<KeyframeTarget> KeyframeComparison::targets(const lie::SE3d& T_body0_body1) const {
  const lie::SE3d& T_body_left = camera_.T_body_left;
  const lie::SE3d T_left1_left0 = T_body_left.inverse() * T_body0_body1.inverse() * T_body_left;
  std::vector<KeyframeTarget> result;
  for (const StereoPoint& point : keyframe_.points) {
    if (const auto found = target(point, T_left1_left0)) result.push_back(*found);
  }
  return result;
}

/// Where the warped patch correlates best around the expected place; then Lucas-Kanade at half
/// size.
std::optional<Correspondence> KeyframeComparison::search(const KeyframeTarget& target,
                                                         double radius) const {
  const int last = static_cast<int>(view_.left.levels().size()) - 1;
  int level = 1;
  while (level < std::min(kCoarsestSearch, last) && radius > kSearchStep * (1 << level)) ++level;
  level = std::min(level, last);
  const double scale = 1.0 / static_cast<double>(1 << level);
  PatchTemplate patch;
  if (!take_warped(then_, target.warp, level, kSearchWindow, patch)) return std::nullopt;
  const int reach = std::clamp(static_cast<int>(std::ceil(radius * scale)), 1, 2 * kSearchStep);
  double best = -1.0;
  Eigen::Vector2d start = target.warp.expected;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const Eigen::Vector2d p = target.warp.expected * scale + Eigen::Vector2d(dx, dy);
      const double correlation = patch.correlation_at(view_.left[level], p);
      if (correlation <= best) continue;
      best = correlation;
      start = p / scale;
    }
  }
  if (best < kScoutCorrelation) return std::nullopt;
  const Alignment found =
      align_warped(then_, target.warp, view_.left, start, level, std::min(1, last), align_);
  if (!found.found || found.correlation < kScoutCorrelation) return std::nullopt;
  Correspondence c;
  c.left0 = target.point->left;
  c.left1 = found.position;
  c.disparity0 = target.point->disparity;
  c.disparity1 = target.disparity;
  c.flow_information = Eigen::Matrix2d::Identity() / (kScoutSigma_px * kScoutSigma_px);
  c.disparity0_information = target.point->disparity_information;
  c.disparity1_information = 0.0;
  return c;
}

std::optional<Correspondence> KeyframeComparison::refine(const KeyframeTarget& target) const {
  const Alignment now =
      align_warped(then_, target.warp, view_.left, target.warp.expected, 2, 0, align_);
  if (!now.found || now.correlation < options_.min_correlation) return std::nullopt;
  PatchWarp back_warp = target.warp.inverse();
  back_warp.center = now.position;
  const Alignment back =
      align_warped(view_.left, back_warp, then_, target.warp.center, 0, 0, align_);
  if (!back.found || (back.position - target.warp.center).norm() > vo_.klt.max_round_trip) {
    return std::nullopt;
  }
  const StereoMatcher stereo(vo_.klt, view_.left, view_.right);
  const std::optional<Disparity> disparity = stereo.refine(now.position, target.disparity);
  if (!disparity) return std::nullopt;
  const double floor = vo_.klt.sigma_floor * vo_.klt.sigma_floor;
  const Eigen::Matrix2d information =
      (now.covariance + floor * Eigen::Matrix2d::Identity()).inverse();
  Correspondence c;
  c.left0 = target.point->left;
  c.left1 = now.position;
  c.disparity0 = target.point->disparity;
  c.disparity1 = disparity->value;
  c.flow_information = 0.5 * (information + information.transpose());
  c.disparity0_information = target.point->disparity_information;
  c.disparity1_information = 1.0 / (disparity->variance + floor);
  return c;
}

std::optional<lie::SE3d> KeyframeComparison::scout(const PredictedMotion& predicted) const {
  const std::vector<KeyframeTarget> all = targets(predicted.T_body0_body1);
  const std::size_t stride = std::max<std::size_t>(1, all.size() / kScouts);
  const double sigma_t = std::sqrt(predicted.covariance.diagonal().head<3>().maxCoeff());
  const double sigma_r = std::sqrt(predicted.covariance.diagonal().tail<3>().maxCoeff());
  double widest = 0.0;
  std::vector<std::optional<Correspondence>> found(all.size() / stride);
  std::vector<double> radii(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double per_metre =
        std::max(all[i * stride].disparity - offset_, kMinDisparity) / camera_.baseline_m;
    radii[i] = kSearchSigmas * std::hypot(camera_.fx * sigma_r, per_metre * sigma_t);
    widest = std::max(widest, radii[i]);
  }
  if (widest < kSureRadius) return predicted.T_body0_body1;
  parallel_chunks(found.size(),
                  [&](std::size_t i) { found[i] = search(all[i * stride], radii[i]); });
  Correspondences matches;
  for (const auto& c : found) {
    if (c) matches.push_back(*c);
  }
  const PoseLayerResult pose =
      solve_pose(matches, camera_, vo_.pose, predicted.T_body0_body1, offset_);
  const double share =
      static_cast<double>(pose.inliers) / std::max(1.0, static_cast<double>(matches.size()));
  if (!pose.valid || pose.inliers < kMinScouts || share < kScoutShare) return std::nullopt;
  return pose.T_body0_body1;
}

bool KeyframeComparison::well_spread(const Correspondences& matches,
                                     const PoseLayerResult& pose) const {
  int cells = 0;
  std::vector<char> held(kGrid * kGrid, 0);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (pose.is_inlier[i] == 0) continue;
    const int x =
        std::clamp(static_cast<int>(kGrid * matches[i].left1.x() / camera_.width), 0, kGrid - 1);
    const int y =
        std::clamp(static_cast<int>(kGrid * matches[i].left1.y() / camera_.height), 0, kGrid - 1);
    char& cell = held[static_cast<std::size_t>(y * kGrid + x)];
    if (cell == 0) ++cells;
    cell = 1;
  }
  return cells >= kMinCells;
}

std::optional<PoseLayerResult> KeyframeComparison::measure(const lie::SE3d& T_body0_body1) const {
  const std::vector<KeyframeTarget> all = targets(T_body0_body1);
  if (all.size() < static_cast<std::size_t>(options_.min_inliers)) return std::nullopt;
  std::vector<std::optional<Correspondence>> found(all.size());
  parallel_chunks(all.size(), [&](std::size_t i) { found[i] = refine(all[i]); });
  Correspondences matches;
  for (const auto& c : found) {
    if (c) matches.push_back(*c);
  }
  PoseLayerResult pose = solve_pose(matches, camera_, vo_.pose, T_body0_body1, offset_);
  const auto inliers = static_cast<double>(pose.inliers);
  const bool enough = pose.valid && pose.inliers >= options_.min_inliers &&
                      inliers >= kMatchShare * static_cast<double>(matches.size()) &&
                      inliers >= options_.min_inlier_share * static_cast<double>(all.size());
  if (!enough || !well_spread(matches, pose)) return std::nullopt;
  return pose;
}

}  // namespace imslam::vo

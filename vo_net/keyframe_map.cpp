#include "vo_net/keyframe_map.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imslam::vo {
namespace {

constexpr std::size_t kProbes = 60;       // points of a view that stand for all
constexpr double kMinDisparity = 0.1;     // [px] farther points are as good as at infinity
constexpr double kMaxZoom = 1.6;          // of depths: patches of other sizes do not match well
constexpr double kMinCosParallax = 0.92;  // 23 degrees: beyond, surfaces look different

}  // namespace

double similarity(const Keyframe& keyframe,
                  const lie::SE3d& T_map_left,
                  const StereoCamera& camera) {
  const lie::SE3d T_now_then = T_map_left.inverse() * keyframe.T_map_left;
  const std::size_t stride = std::max<std::size_t>(1, keyframe.points.size() / kProbes);
  std::size_t probes = 0;
  std::size_t alike = 0;
  for (std::size_t i = 0; i < keyframe.points.size(); i += stride, ++probes) {
    const StereoPoint& point = keyframe.points[i];
    const double d = std::max(point.disparity, kMinDisparity);
    const Eigen::Vector3d then = camera.back_project({point.left.x(), point.left.y(), d});
    const Eigen::Vector3d now = T_now_then * then;
    if (!(now.z() > 0.0) || now.z() > kMaxZoom * then.z() || then.z() > kMaxZoom * now.z()) {
      continue;
    }
    const Eigen::Vector3d uvd = camera.project(now);
    if (uvd.x() < 0.0 || uvd.y() < 0.0 || uvd.x() > camera.width || uvd.y() > camera.height) {
      continue;
    }
    const double cosine = (T_now_then.rotation() * then).dot(now) / (then.norm() * now.norm());
    if (cosine > kMinCosParallax) ++alike;
  }
  return probes == 0 ? 0.0 : static_cast<double>(alike) / static_cast<double>(probes);
}

KeyframeMap::KeyframeMap(const LoopOptions& options, const StereoCamera& camera)
    : options_(options), camera_(camera) {
  options_.validate();
}

std::size_t KeyframeMap::capacity() const {
  const std::size_t image =
      static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
  const std::size_t each = sizeof(Keyframe) + image +
                           2 * static_cast<std::size_t>(options_.max_points) * sizeof(StereoPoint);
  const auto fitting = static_cast<std::size_t>(options_.max_memory_mb * 1e6) / each;
  return std::clamp<std::size_t>(fitting, 1, static_cast<std::size_t>(options_.max_keyframes));
}

std::size_t KeyframeMap::bytes() const {
  std::size_t sum = 0;
  for (const Entry& entry : entries_) {
    sum += entry.keyframe.bytes() + entry.to_older.capacity() * sizeof(double);
  }
  return sum;
}

void KeyframeMap::add(Keyframe keyframe) {
  while (entries_.size() >= capacity()) make_room();
  Entry entry;
  for (const Entry& older : entries_) {
    entry.to_older.push_back(similarity(older.keyframe, keyframe.T_map_left, camera_));
  }
  entry.keyframe = std::move(keyframe);
  entries_.push_back(std::move(entry));
}

void KeyframeMap::move(const lie::SE3d& T_body0_body1,
                       const Eigen::Matrix<double, 6, 6>& covariance) {
  const Eigen::Matrix<double, 6, 6> A = T_body0_body1.inverse().adjoint();
  for (Entry& entry : entries_) {
    Eigen::Matrix<double, 6, 6>& known = entry.keyframe.covariance;
    known = A * known * A.transpose() + covariance;
  }
}

Keyframe* KeyframeMap::at(std::int64_t time_ns) {
  for (Entry& entry : entries_) {
    if (entry.keyframe.time_ns == time_ns) return &entry.keyframe;
  }
  return nullptr;
}

void KeyframeMap::make_room() {
  std::size_t leaving = entries_.size() - 1;
  double highest = -1.0;
  for (std::size_t i = 1; i < entries_.size(); ++i) {
    const auto& to_older = entries_[i].to_older;
    const double nearest = *std::max_element(to_older.begin(), to_older.end());
    if (nearest <= highest) continue;
    highest = nearest;
    leaving = i;
  }
  for (std::size_t i = leaving + 1; i < entries_.size(); ++i) {
    auto& to_older = entries_[i].to_older;
    to_older.erase(to_older.begin() + static_cast<std::ptrdiff_t>(leaving));
  }
  entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(leaving));
}

std::vector<KeyframeMap::Candidate> KeyframeMap::candidates(const lie::SE3d& T_map_left,
                                                            std::int64_t time_ns) const {
  const auto gap_ns = static_cast<std::int64_t>(options_.min_gap_s * 1e9);
  std::vector<Candidate> found;
  for (const Entry& entry : entries_) {
    if (time_ns - entry.keyframe.time_ns < gap_ns) break;
    const double alike = similarity(entry.keyframe, T_map_left, camera_);
    if (alike >= options_.min_similarity) found.push_back({&entry.keyframe, alike});
  }
  if (found.empty()) return found;
  const auto best = std::max_element(
      found.begin(), found.end(),
      [](const Candidate& a, const Candidate& b) { return a.similarity < b.similarity; });
  std::rotate(found.begin(), best, best + 1);  // the others stay in order of time
  if (found.size() > static_cast<std::size_t>(options_.max_edges)) {
    found.resize(static_cast<std::size_t>(options_.max_edges));
  }
  return found;
}

bool KeyframeMap::is_new_view(const lie::SE3d& T_map_left) const {
  return std::none_of(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return similarity(entry.keyframe, T_map_left, camera_) >= options_.new_view;
  });
}

}  // namespace imslam::vo

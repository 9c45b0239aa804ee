#include "vo_net/klt_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "slam/base/error.hpp"
#include "vo_net/corner_detector.hpp"
#include "vo_net/patch_aligner.hpp"
#include "vo_net/stereo_matcher.hpp"
#include "vo_net/track.hpp"

namespace imslam::vo {
namespace {

constexpr double kMinSurvivors = 0.3;  // fewer: the prediction may have been wrong

}  // namespace

class KltMatcher::State {
 public:
  State(const KltOptions& options_in, const StereoCamera& camera_in)
      : options(options_in.for_width(camera_in.width)), camera(camera_in) {
    options.validate();
    align.window = options.window;
    align.smoothing = options.smoothing;
  }

  MatchResult match(const StereoFrame& frame, const lie::SE3d& T_left0_left1);
  void drop(const std::vector<std::int64_t>& ids) { erase_tracks(tracks_, ids); }
  void forget_newest();

  KltOptions options;
  StereoCamera camera;

 private:
  /// A track of the frame before, found again in the new one.
  struct Followed {
    std::optional<Correspondence> match;
    Track track;
  };
  struct Keyframe {
    std::int64_t time_ns = 0;
    int age = 0;
    ImagePyramid left;
    std::vector<Track> tracks;  // by increasing id
  };

  std::vector<Followed> follow_all(const lie::SE3d& T_left1_left0);
  Followed follow(const Track& track, const lie::SE3d& T_left1_left0) const;
  std::optional<Alignment> follow_left(const ImagePyramid& from,
                                       const Eigen::Vector2d& center,
                                       const Eigen::Vector2d& start,
                                       int level) const;
  void add_corners();
  void match_previous(const lie::SE3d& T_left0_left1, FrameMatch& match);
  void match_keyframe(MatchResult& result);
  void tend_keyframe(std::int64_t time_ns, MatchResult& result);
  void replace_keyframe(std::int64_t time_ns);

  AlignOptions align;
  ImagePyramid left_before_;
  ImagePyramid left_;
  ImagePyramid right_;
  std::int64_t time_ns_ = 0;  // of the newest frame
  std::int64_t time_before_ns_ = 0;
  int frames_ = 0;
  std::vector<Track> tracks_;
  std::vector<Track> tracks_before_;  // as they were in the frame before
  std::int64_t next_id_ = 0;
  Keyframe keyframe_;
};

std::optional<Alignment> KltMatcher::State::follow_left(const ImagePyramid& from,
                                                        const Eigen::Vector2d& center,
                                                        const Eigen::Vector2d& start,
                                                        int level) const {
  const Alignment forth = align_patch(from, center, left_, start, level, align, false);
  if (!forth.found || forth.correlation < options.min_correlation) return std::nullopt;
  const Alignment back = align_patch(left_, forth.position, from, center, 0, align, false);
  if (!back.found || (back.position - center).norm() > options.max_round_trip) return std::nullopt;
  return forth;
}

KltMatcher::State::Followed KltMatcher::State::follow(const Track& track,
                                                      const lie::SE3d& T_left1_left0) const {
  Followed followed;
  const Eigen::Vector3d expected = predict(camera, track, T_left1_left0);
  const std::optional<Alignment> left1 =
      follow_left(left_before_, track.left, expected.head<2>(), options.levels - 1);
  if (!left1) return followed;
  const StereoMatcher stereo(options, left_, right_);
  const std::optional<Disparity> disparity1 = stereo.refine(left1->position, expected.z());
  if (!disparity1) return followed;
  followed.track = {track.id, left1->position, *disparity1};
  followed.match = make_correspondence(track, {left1->position, left1->covariance}, followed.track,
                                       options.sigma_floor);
  return followed;
}

std::vector<KltMatcher::State::Followed> KltMatcher::State::follow_all(
    const lie::SE3d& T_left1_left0) {
  std::vector<Followed> followed(tracks_.size());
  parallel_points(tracks_.size(),
                  [&](std::size_t i) { followed[i] = follow(tracks_[i], T_left1_left0); });
  return followed;
}

void KltMatcher::State::add_corners() {
  std::vector<Eigen::Vector2d> taken;
  for (const Track& track : tracks_) taken.push_back(track.left);
  CornerOptions corner_options;
  corner_options.max_points = options.max_points;
  corner_options.min_quality = options.min_quality;
  corner_options.margin = options.window / 2 + 4;
  const std::vector<Eigen::Vector2d> corners = detect_corners(left_, taken, corner_options);

  const StereoMatcher stereo(options, left_, right_);
  std::vector<std::optional<Disparity>> disparities(corners.size());
  parallel_points(corners.size(),
                  [&](std::size_t i) { disparities[i] = stereo.search(corners[i]); });
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (disparities[i]) tracks_.push_back({next_id_++, corners[i], *disparities[i]});
  }
}

void KltMatcher::State::match_keyframe(MatchResult& result) {
  std::vector<std::pair<const Track*, const Track*>> pairs;  // keyframe, now
  auto old = keyframe_.tracks.begin();
  for (const Track& track : tracks_) {
    while (old != keyframe_.tracks.end() && old->id < track.id) ++old;
    if (old != keyframe_.tracks.end() && old->id == track.id) pairs.emplace_back(&*old, &track);
  }
  std::vector<std::optional<Correspondence>> found(pairs.size());
  parallel_points(pairs.size(), [&](std::size_t i) {
    const auto [before, now] = pairs[i];
    const std::optional<Alignment> left1 = follow_left(keyframe_.left, before->left, now->left, 0);
    // The disparity belongs to where the chain of small steps ended, a fraction of a pixel away.
    if (left1 && (left1->position - now->left).norm() < 1.0) {
      found[i] = make_correspondence(*before, {left1->position, left1->covariance}, *now,
                                     options.sigma_floor);
    }
  });
  FrameMatch match;
  match.time0_ns = keyframe_.time_ns;
  for (const auto& c : found) {
    if (c) match.correspondences.push_back(*c);
  }
  result.earlier.push_back(std::move(match));
}

void KltMatcher::State::replace_keyframe(std::int64_t time_ns) {
  keyframe_.time_ns = time_ns;
  keyframe_.age = 0;
  keyframe_.left = left_;
  keyframe_.tracks = tracks_;
}

void KltMatcher::State::match_previous(const lie::SE3d& T_left0_left1, FrameMatch& match) {
  const auto survivors = [](const std::vector<Followed>& all) {
    return std::count_if(all.begin(), all.end(),
                         [](const Followed& f) { return f.match.has_value(); });
  };
  std::vector<Followed> followed = follow_all(T_left0_left1.inverse());
  if (static_cast<double>(survivors(followed)) <
      kMinSurvivors * static_cast<double>(tracks_.size())) {
    std::vector<Followed> at_rest = follow_all(lie::SE3d());
    if (survivors(at_rest) > survivors(followed)) followed = std::move(at_rest);
  }
  tracks_.clear();
  for (const Followed& f : followed) {
    if (!f.match) continue;
    match.correspondences.push_back(*f.match);
    tracks_.push_back(f.track);
  }
}

void KltMatcher::State::tend_keyframe(std::int64_t time_ns, MatchResult& result) {
  if (frames_ > 0 && ++keyframe_.age >= 2) match_keyframe(result);
  const bool outrun = !result.earlier.empty() &&
                      static_cast<double>(result.earlier.front().correspondences.size()) <
                          options.keyframe_overlap * static_cast<double>(tracks_.size());
  if (frames_ > 0 && keyframe_.age < options.keyframe_age && !outrun) return;
  add_corners();
  replace_keyframe(time_ns);
}

MatchResult KltMatcher::State::match(const StereoFrame& frame, const lie::SE3d& T_left0_left1) {
  std::swap(left_, left_before_);
  time_before_ns_ = std::exchange(time_ns_, frame.time_ns);
  tracks_before_ = tracks_;
  left_.build(frame.left, options.levels, options.smoothing);
  right_.build(frame.right, options.levels, options.smoothing);

  MatchResult result;
  result.previous.time0_ns = time_before_ns_;
  if (frames_ > 0) match_previous(T_left0_left1, result.previous);
  if (options.keyframe_age > 0) tend_keyframe(frame.time_ns, result);
  add_corners();
  for (const Track& track : tracks_) {
    result.points.push_back(make_stereo_point(track, options.sigma_floor));
  }
  ++frames_;
  return result;
}

void KltMatcher::State::forget_newest() {
  expects(frames_ > 0, "KltMatcher::forget_newest: there is no frame");
  std::swap(left_, left_before_);
  tracks_ = std::move(tracks_before_);
  tracks_before_.clear();
  if (keyframe_.time_ns == time_ns_) keyframe_.tracks.clear();  // it was the forgotten frame
  time_ns_ = time_before_ns_;
  --frames_;
}

KltMatcher::KltMatcher(const KltOptions& options, const StereoCamera& camera)
    : state_(std::make_unique<State>(options, camera)) {}

KltMatcher::~KltMatcher() = default;

MatchResult KltMatcher::match(const StereoFrame& frame, const lie::SE3d& T_body0_body1_predicted) {
  expects(frame.complete(), "KltMatcher::match: both images must be there");
  const lie::SE3d& T_body_left = state_->camera.T_body_left;
  return state_->match(frame, T_body_left.inverse() * T_body0_body1_predicted * T_body_left);
}

void KltMatcher::drop(const std::vector<std::int64_t>& track_ids) { state_->drop(track_ids); }

void KltMatcher::forget_newest() { state_->forget_newest(); }

void KltMatcher::reset() { state_ = std::make_unique<State>(state_->options, state_->camera); }

}  // namespace imslam::vo

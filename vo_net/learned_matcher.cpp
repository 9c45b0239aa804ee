#include "vo_net/learned_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "vo_net/corner_detector.hpp"
#include "vo_net/match_inference.hpp"
#include "vo_net/match_polish.hpp"
#include "vo_net/track.hpp"

namespace imslam::vo {
namespace {

constexpr int kLevels = 2;              // at least: corners are looked for at half size
constexpr double kMinSurvivors = 0.3;   // fewer: the prediction may have been wrong
constexpr double kHard = 0.5;           // share of polished matches: fewer need a closer look,
constexpr double kEasyAgain = 0.65;     // with more the coarse one is enough again
constexpr double kMinDisparity = -1.0;  // [px] noise may carry a far point beyond infinity

bool is_inside(const StereoCamera& camera, const Eigen::Vector2d& p) {
  return p.x() >= 0.0 && p.y() >= 0.0 && p.x() <= camera.width - 1 && p.y() <= camera.height - 1;
}

/// The median of each coordinate: a few points of wrong depth do not matter.
Eigen::Vector2d median(std::vector<Eigen::Vector2d> values) {
  if (values.empty()) return Eigen::Vector2d::Zero();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  Eigen::Vector2d result;
  for (int axis = 0; axis < 2; ++axis) {
    std::nth_element(values.begin(), middle, values.end(),
                     [=](const auto& a, const auto& b) { return a[axis] < b[axis]; });
    result[axis] = (*middle)[axis];
  }
  return result;
}

/// Leaves the oldest track of each cell: where the scene shrinks, tracks come to crowd, and each
/// costs time.
void leave_one_per_cell(std::vector<Track>& tracks, double side) {
  std::set<std::pair<int, int>> occupied;
  const auto crowds = [&](const Track& track) {
    const Eigen::Vector2i cell = (track.left / side).array().floor().cast<int>();
    return !occupied.emplace(cell.x(), cell.y()).second;
  };
  std::vector<Track> kept;
  for (const Track& track : tracks) {  // by age
    if (!crowds(track)) kept.push_back(track);
  }
  tracks = std::move(kept);
}

}  // namespace

class LearnedMatcher::State {
 public:
  State(const LearnedMatcherOptions& options_in,
        const StereoCamera& camera_in,
        std::shared_ptr<MatchNetwork<float>> network_in)
      : options(options_in.for_width(camera_in.width)),
        camera(camera_in),
        network(std::move(network_in)),
        inference_(network),
        polish_(options) {
    options.validate();
  }

  MatchResult match(const StereoFrame& frame, const lie::SE3d& T_left0_left1);
  void drop(const std::vector<std::int64_t>& ids) { erase_tracks(tracks_, ids); }
  void forget_newest();

  LearnedMatcherOptions options;
  StereoCamera camera;
  std::shared_ptr<MatchNetwork<float>> network;

 private:
  using Arrivals = std::vector<std::optional<Arrival>>;  // one per track

  Arrivals follow(const Eigen::Vector2d& predicted);
  Arrivals follow(const lie::SE3d& T_left1_left0);
  Arrival refine_flow(const Eigen::Vector2d& left0, const NetworkAnswer& answer) const;
  std::vector<Eigen::Vector2d> new_points(const std::vector<Eigen::Vector2d>& taken) const;
  std::vector<std::optional<Track>> measure_depth(const std::vector<Eigen::Vector2d>& left);
  Disparity refine_disparity(const Eigen::Vector2d& left, const NetworkAnswer& answer) const;
  void move_tracks(const Arrivals& arrivals, FrameMatch& match);

  int shrink() const;
  void judge_effort(const Arrivals& arrivals);

  MatchInference inference_;
  MatchPolish polish_;
  ImagePyramid left_before_;
  ImagePyramid left_;
  ImagePyramid right_;
  std::int64_t time_ns_ = 0;  // of the newest frame
  std::int64_t time_before_ns_ = 0;
  MatchSearch search_;    // of the newest frame
  bool is_hard_ = false;  // the network's own answers count, not only where they lead to
  int frames_ = 0;
  std::vector<Track> tracks_;
  std::vector<Track> tracks_before_;  // as they were in the frame before
  std::int64_t next_id_ = 0;
};

int LearnedMatcher::State::shrink() const {
  const int widest = is_hard_ ? options.max_width_hard : options.max_width;
  return (camera.width + widest - 1) / widest;
}

void LearnedMatcher::State::judge_effort(const Arrivals& arrivals) {
  const auto arrived =
      std::count_if(arrivals.begin(), arrivals.end(), [](const auto& a) { return a.has_value(); });
  const auto polished = std::count_if(arrivals.begin(), arrivals.end(),
                                      [](const auto& a) { return a && !a->learned && !a->coarse; });
  const double share =
      arrived == 0 ? 0.0 : static_cast<double>(polished) / static_cast<double>(arrived);
  is_hard_ = share < (is_hard_ ? kEasyAgain : kHard);
}

Arrival LearnedMatcher::State::refine_flow(const Eigen::Vector2d& left0,
                                           const NetworkAnswer& answer) const {
  const auto better = polish_.polish(left_before_, left0, left_, answer);
  if (better) return {better->position, better->covariance, answer.confidence, false};
  const auto coarse = polish_.polish_coarse(left_before_, left0, left_, answer);
  if (coarse) return {coarse->position, coarse->covariance, answer.confidence, false, true};
  return {left0 + answer.displacement, answer.covariance, answer.confidence, true};
}

LearnedMatcher::State::Arrivals LearnedMatcher::State::follow(const Eigen::Vector2d& predicted) {
  std::vector<Eigen::Vector2d> points;
  for (const Track& track : tracks_) points.push_back(track.left);
  const std::vector<NetworkAnswer> answers = inference_.flow(points, predicted);
  search_.predicted = predicted;
  Arrivals arrivals(tracks_.size());
  parallel_points(tracks_.size(), [&](std::size_t i) {
    if (answers[i].confidence < options.min_confidence) return;
    const Arrival arrival = refine_flow(points[i], answers[i]);
    if (!is_inside(camera, arrival.left) || !polish_.shows_something(left_, arrival.left)) return;
    arrivals[i] = arrival;
  });
  judge_effort(arrivals);
  return arrivals;
}

LearnedMatcher::State::Arrivals LearnedMatcher::State::follow(const lie::SE3d& T_left1_left0) {
  const auto survivors = [](const Arrivals& all) {
    return std::count_if(all.begin(), all.end(), [](const auto& a) { return a.has_value(); });
  };
  std::vector<Eigen::Vector2d> displacements;
  for (const Track& track : tracks_) {
    const Eigen::Vector3d expected = predict(camera, track, T_left1_left0);
    displacements.push_back(expected.head<2>() - track.left);
  }
  const Eigen::Vector2d predicted = median(std::move(displacements));
  Arrivals arrivals = follow(predicted);
  const bool few = static_cast<double>(survivors(arrivals)) <
                   kMinSurvivors * static_cast<double>(tracks_.size());
  if (few && predicted.norm() > CoarseMatcher<float>::kStride) {
    Arrivals at_rest = follow(Eigen::Vector2d(Eigen::Vector2d::Zero()));
    if (survivors(at_rest) > survivors(arrivals)) return at_rest;
    search_.predicted = predicted;
  }
  return arrivals;
}

std::vector<Eigen::Vector2d> LearnedMatcher::State::new_points(
    const std::vector<Eigen::Vector2d>& taken) const {
  CornerOptions corner_options;
  corner_options.max_points = options.max_points;
  corner_options.margin = options.polish_window / 2 + 4;
  corner_options.fill_cells = true;  // the network says whether they can be used
  std::vector<Eigen::Vector2d> points = detect_corners(left_, taken, corner_options);
  const auto blank = [&](const auto& p) { return !polish_.shows_something(left_, p); };
  points.erase(std::remove_if(points.begin(), points.end(), blank), points.end());
  return points;
}

Disparity LearnedMatcher::State::refine_disparity(const Eigen::Vector2d& left,
                                                  const NetworkAnswer& answer) const {
  NetworkAnswer along_row = answer;
  along_row.covariance(1, 1) = 0.0;
  const auto better = polish_.polish(left_, left, right_, along_row);
  if (better && std::abs(better->position.y() - left.y()) <= options.max_row_error) {
    return {left.x() - better->position.x(), better->covariance(0, 0),
            better->position.y() - left.y(), false};
  }
  return {-answer.displacement.x(), answer.covariance(0, 0), 0.0, true};
}

std::vector<std::optional<Track>> LearnedMatcher::State::measure_depth(
    const std::vector<Eigen::Vector2d>& left) {
  const std::vector<NetworkAnswer> answers = inference_.stereo(left);
  std::vector<std::optional<Track>> measured(left.size());
  parallel_points(left.size(), [&](std::size_t i) {
    if (answers[i].confidence < options.min_confidence) return;
    const Disparity disparity = refine_disparity(left[i], answers[i]);
    const Eigen::Vector2d right = left[i] - Eigen::Vector2d(disparity.value, 0.0);
    if (disparity.value < kMinDisparity || !is_inside(camera, right) ||
        !polish_.shows_something(right_, right)) {
      return;
    }
    measured[i] = Track{-1, left[i], disparity, answers[i].confidence};
  });
  return measured;
}

void LearnedMatcher::State::move_tracks(const Arrivals& arrivals, FrameMatch& match) {
  std::vector<Eigen::Vector2d> points;
  std::vector<std::size_t> from;  // index of the track, of the first points
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    if (!arrivals[i]) continue;
    points.push_back(arrivals[i]->left);
    from.push_back(i);
  }
  const std::vector<Eigen::Vector2d> fresh = new_points(points);
  points.insert(points.end(), fresh.begin(), fresh.end());
  std::vector<std::optional<Track>> measured = measure_depth(points);

  std::vector<Track> now;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!measured[k]) continue;
    Track& track = *measured[k];
    if (k < from.size()) {
      const Track& before = tracks_[from[k]];
      track.id = before.id;
      match.correspondences.push_back(
          make_correspondence(before, *arrivals[from[k]], track, options.sigma_floor));
    } else {
      track.id = next_id_++;
    }
    now.push_back(track);
  }
  tracks_ = std::move(now);
}

MatchResult LearnedMatcher::State::match(const StereoFrame& frame, const lie::SE3d& T_left0_left1) {
  std::swap(left_, left_before_);
  time_before_ns_ = std::exchange(time_ns_, frame.time_ns);
  tracks_before_ = tracks_;
  const int levels = std::max(kLevels, options.coarse_polish + 1);
  parallel_for(2, [&](std::size_t i) {
    if (i == 0) left_.build(frame.left, levels, options.smoothing);
    if (i == 1) right_.build(frame.right, 1, options.smoothing);
  });
  search_ = {Eigen::Vector2d::Zero(), shrink()};
  inference_.advance(frame.left, frame.right, search_.shrink);

  MatchResult result;
  result.previous.time0_ns = time_before_ns_;
  Arrivals arrivals;
  if (frames_ > 0) arrivals = follow(T_left0_left1.inverse());
  result.previous.search = search_;
  move_tracks(arrivals, result.previous);
  for (const Track& track : tracks_) {
    result.points.push_back(make_stereo_point(track, options.sigma_floor));
  }
  leave_one_per_cell(tracks_, cell_side(camera.width, camera.height, options.max_points));
  ++frames_;
  return result;
}

void LearnedMatcher::State::forget_newest() {
  expects(frames_ > 0, "LearnedMatcher::forget_newest: there is no frame");
  std::swap(left_, left_before_);
  inference_.step_back();
  tracks_ = std::move(tracks_before_);
  tracks_before_.clear();
  time_ns_ = time_before_ns_;
  --frames_;
}

LearnedMatcher::LearnedMatcher(const LearnedMatcherOptions& options,
                               const StereoCamera& camera,
                               std::shared_ptr<MatchNetwork<float>> network)
    : state_(std::make_unique<State>(options, camera, std::move(network))) {}

LearnedMatcher::~LearnedMatcher() = default;

MatchResult LearnedMatcher::match(const StereoFrame& frame,
                                  const lie::SE3d& T_body0_body1_predicted) {
  expects(frame.complete(), "LearnedMatcher::match: both images must be there");
  const lie::SE3d& T_body_left = state_->camera.T_body_left;
  return state_->match(frame, T_body_left.inverse() * T_body0_body1_predicted * T_body_left);
}

void LearnedMatcher::drop(const std::vector<std::int64_t>& track_ids) { state_->drop(track_ids); }

void LearnedMatcher::forget_newest() { state_->forget_newest(); }

void LearnedMatcher::reset() {
  state_ = std::make_unique<State>(state_->options, state_->camera, state_->network);
}

}  // namespace imslam::vo

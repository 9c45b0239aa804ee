#include "slam/plugins/routing/tour_search.hpp"

#include <algorithm>
#include <utility>

namespace imslam::routing {
namespace {

/// More than what rounding could take back and forth, of distances about 1.
constexpr double kLeastGain = 1e-7;
constexpr int kLongestSegment = 3;  ///< of Or-opt
constexpr int kLongestKick = 30;    ///< places in each segment of the double bridge
constexpr int kBetweenClockLooks = 16;

/// Mean distance to the nearest place: what roads that are taken are like.
double usual_distance(const Distances& distances,
                      const Neighbours& near,
                      const std::vector<std::int32_t>& places) {
  double sum = 0.0;
  for (const std::int32_t place : places) {
    if (near.count() > 0) sum += distances(place, *near.of(place).begin());
  }
  return sum / std::max(1.0, static_cast<double>(places.size()));
}

}  // namespace

TourSearch::TourSearch(const Distances& distances,
                       const Neighbours& near,
                       std::vector<std::int32_t> order)
    : distances_(distances),
      near_(near),
      tour_(std::move(order)),
      queued_(static_cast<std::size_t>(tour_.count()), 0),
      least_gain_(kLeastGain * std::max(1.0, usual_distance(distances, near, tour_.order()))) {}

double TourSearch::length() const {
  double length = 0.0;
  for (int p = 0; p < tour_.count(); ++p)
    length += distances_(tour_.at(p), tour_.next(tour_.at(p)));
  return length;
}

void TourSearch::descend() {
  if (tour_.count() < 4) return;
  queue_.assign(tour_.order().rbegin(), tour_.order().rend());
  std::fill(queued_.begin(), queued_.end(), 1);
  work_off();
  tour_.forget();
}

void TourSearch::work_off() {
  while (!queue_.empty()) {
    const int place = queue_.back();
    queue_.pop_back();
    queued_[static_cast<std::size_t>(place)] = 0;
    while (improve(place)) {
    }
  }
}

void TourSearch::look_again(std::initializer_list<int> places) {
  for (const int place : places) {
    char& queued = queued_[static_cast<std::size_t>(place)];
    if (queued == 0) queue_.push_back(place);
    queued = 1;
  }
}

bool TourSearch::improve(int place) {
  if (!distances_.symmetric()) return swap_segments(place, true);
  for (const bool onward : {true, false}) {
    if (exchange(place, onward) || move_segment(place, onward) || swap_segments(place, onward)) {
      return true;
    }
  }
  return false;
}

/// 2-opt: place a leaves its neighbour b for a nearer c; b gets c's neighbour d.
bool TourSearch::exchange(int a, bool onward) {
  const int b = next(a, onward);
  const double leaves = distances_(a, b);
  for (const int c : near_.of(a)) {
    const double gain = leaves - distances_(a, c);
    if (!(gain > least_gain_)) return false;
    const int d = next(c, onward);
    if (c == b || d == a) continue;
    const double gained = gain + distances_(c, d) - distances_(b, d);
    if (!(gained > least_gain_)) continue;
    tour_.exchange(a, b, c, d);
    gained_ += gained;
    look_again({a, b, c, d});
    return true;
  }
  return false;
}

/// Or-opt: one to three places from `first` on go somewhere near `first`.
bool TourSearch::move_segment(int first, bool onward) {
  const int before = next(first, !onward);
  int last = first;
  for (int length = 1; length <= kLongestSegment; ++length, last = next(last, onward)) {
    const int after = next(last, onward);
    if (after == before || next(after, onward) == before) return false;
    const double gain =
        distances_(before, first) + distances_(last, after) - distances_(before, after);
    if (place_segment(first, last, gain, onward)) return true;
  }
  return false;
}

/// `first` comes next to a near c, `last` next to the neighbour e of c on either side.
bool TourSearch::place_segment(int first, int last, double gain, bool onward) {
  const int before = next(first, !onward);
  const int after = next(last, onward);
  const int length = onward ? tour_.steps(first, last) : tour_.steps(last, first);
  for (const int c : near_.of(first)) {
    const double left = gain - distances_(first, c);
    if (!(left > least_gain_)) return false;
    const int offset = onward ? tour_.steps(first, c) : tour_.steps(c, first);
    if (offset <= length) continue;  // within the segment
    for (const bool same : {true, false}) {
      const int e = next(c, same == onward);
      if (e == first || e == last) continue;
      const double gained = left + distances_(c, e) - distances_(last, e);
      if (!(gained > least_gain_)) continue;
      const int low = same ? c : e;  // the gap in the direction of the segment
      const int high = same ? e : c;
      tour_.swap_segments(before, first, last, after, low, high);
      if (!same) tour_.exchange(low, first, last, high);
      gained_ += gained;
      look_again({before, first, last, after, c, e});
      return true;
    }
  }
  return false;
}

/// Or-3opt: a b .. c d .. e f  ->  a d .. e b .. c f  with e near b and c near f.
bool TourSearch::swap_segments(int b, bool onward) {
  const int a = next(b, !onward);
  const double leaves = way(a, b, onward);
  for (const int e : near_.of(b)) {
    const double first = leaves - way(e, b, onward);
    if (!(first > least_gain_)) return false;
    const int f = next(e, onward);
    if (e == a) continue;
    const double second = first + way(e, f, onward);
    for (const int c : near_.of(f)) {
      const double third = second - way(c, f, onward);
      if (!(third > least_gain_)) break;
      const int span = onward ? tour_.steps(b, e) : tour_.steps(e, b);
      const int at = onward ? tour_.steps(b, c) : tour_.steps(c, b);
      if (at >= span) continue;  // c lies between b and e
      const int d = next(c, onward);
      const double gained = third + way(c, d, onward) - way(a, d, onward);
      if (!(gained > least_gain_)) continue;
      tour_.swap_segments(a, b, c, d, e, f);
      gained_ += gained;
      look_again({a, b, c, d, e, f});
      return true;
    }
  }
  return false;
}

/// A double bridge within a short stretch: what is far away stays as it is.
void TourSearch::kick(Random& random) {
  const int n = tour_.count();
  const int longest = std::min(kLongestKick, (n - 2) / 2);
  const int start = static_cast<int>(random.integer(0, n - 1));
  const int left = static_cast<int>(random.integer(1, longest));
  const int right = static_cast<int>(random.integer(1, longest));
  const auto at = [&](int k) { return tour_.at((start + k) % n); };
  const int a = at(0), b = at(1), c = at(left), d = at(left + 1);
  const int e = at(left + right), f = at(left + right + 1);
  gained_ = distances_(a, b) + distances_(c, d) + distances_(e, f) - distances_(a, d) -
            distances_(e, b) - distances_(c, f);
  tour_.swap_segments(a, b, c, d, e, f);
  look_again({a, b, c, d, e, f});
}

std::int64_t TourSearch::disturb(const StopRule& stop, Random& random) {
  if (tour_.count() < 5) return 0;
  std::int64_t done = 0;
  while (done % kBetweenClockLooks != 0 || stop.progress(done) < 1.0) {
    kick(random);
    work_off();
    if (gained_ < -least_gain_) {
      tour_.go_back();
    } else {
      tour_.forget();
    }
    ++done;
  }
  return done;
}

}  // namespace imslam::routing

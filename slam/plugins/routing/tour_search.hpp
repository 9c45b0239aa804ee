#pragma once

#include <cstdint>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/plugins/routing/distances.hpp"
#include "slam/plugins/routing/stop_rule.hpp"
#include "slam/plugins/routing/tour_array.hpp"

namespace imslam::routing {

/// Shortens one closed tour through all places of `distances`.
///
///   descend()   2-opt, Or-opt (up to 3 places, turned or not), Or-3opt (two segments change
///               places), only towards near places, and only about places whose surroundings have
///               changed (don't-look bits; Bentley 1992)
///   disturb()   iterated: a swap of two short neighbouring segments somewhere (double bridge),
///               descend(), undone unless the tour is no longer (Martin, Otto, Felten 1991)
///
/// If one way is not as long as the other only Or-3opt is used, which turns no segment around.
class TourSearch {
 public:
  TourSearch(const Distances& distances, const Neighbours& near, std::vector<std::int32_t> order);

  void descend();
  /// Calls itself off by `stop`; returns the iterations done.
  std::int64_t disturb(const StopRule& stop, Random& random);

  const std::vector<std::int32_t>& order() const { return tour_.order(); }
  double length() const;

 private:
  int next(int place, bool onward) const {
    return onward ? tour_.next(place) : tour_.previous(place);
  }
  double way(int a, int b, bool onward) const {
    return onward ? distances_(a, b) : distances_(b, a);
  }
  bool improve(int place);
  bool exchange(int place, bool onward);
  bool move_segment(int place, bool onward);
  bool place_segment(int first, int last, double gain, bool onward);
  bool swap_segments(int place, bool onward);
  void look_again(std::initializer_list<int> places);
  void work_off();
  void kick(Random& random);

  const Distances& distances_;
  const Neighbours& near_;
  TourArray tour_;
  std::vector<std::int32_t> queue_;  ///< to be looked at
  std::vector<char> queued_;
  double gained_ = 0.0;  ///< since the last kick
  double least_gain_;
};

}  // namespace imslam::routing

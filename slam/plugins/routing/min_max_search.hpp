#pragma once

#include <cstdint>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/plugins/routing/fleet.hpp"
#include "slam/plugins/routing/stop_rule.hpp"

namespace imslam::routing {

struct MinMaxOptions {
  double removed = 10.0;    ///< cities per ruin, on average about half of it
  int longest_string = 10;  ///< neighbours on a tour that are taken out together
  double attack = 0.5;      ///< share of ruins that start on the longest tour
  double blink = 0.01;      ///< chance that a near city is overlooked, of each
  double heat = 10.0;       ///< first temperature, in mean edges per agent
  double cold = 0.03;       ///< last temperature
};

/// The unit of temperatures: mean edge per agent.
double mean_edge_per_agent(const Fleet& fleet);

/// Shortens the longest tour: ruin and recreate under simulated annealing.
///
///   minimise  (sum_t L_t^12)^(1/12)      nearly the longest, but others count where it cannot gain
///
///   ruin       strings of neighbours on some adjacent tours, half of the time about a city of the
///              longest one (slack induction by string removal; Christiaens, Vanden Berghe 2020)
///   recreate   one city after the other where the sum grows least, next to one that is near it or
///              to the depot: relocations, swaps and exchanges between tours are special cases
///   accept     f' < f - T log u
///
/// An iteration takes time that depends on what was removed, not on the number of cities.
class MinMaxSearch {
 public:
  MinMaxSearch(Fleet start, const Neighbours& near, const MinMaxOptions& options, Random random);

  /// Iterations while the temperature falls geometrically from `hot` to `cold`, both lengths.
  void anneal(std::int64_t iterations, double hot, double cold);
  /// Another's fleet as it is now, but other chances.
  void go_on_from(const MinMaxSearch& other);
  double sum_of_powers() const;
  /// The fleet with the shortest longest tour that was seen.
  const Fleet& best() const { return best_; }

  /// Puts every city that is in no tour where it lengthens the sum least, the farthest first.
  static Fleet greedy(Fleet fleet, const Neighbours& near);

 private:
  struct Removal {
    int city;
    int previous;
  };
  double power(double length) const;
  int seed_city();
  void ruin();
  void remove_string(int city, int length);
  void order_removed();
  void recreate();
  int best_place(int city, bool blink);
  void note_power(int tour);
  void rollback();
  bool accepts(double sum, double temperature);
  void adopt(double sum);

  Fleet fleet_;
  Fleet best_;
  const Neighbours* near_;
  MinMaxOptions options_;
  Random random_;
  double unit_ = 1.0;  ///< lengths are divided by it, so that powers stay within range
  double sum_ = 0.0;
  double best_longest_ = 0.0;
  struct Power {
    double value = 0.0;  ///< (L / unit)^12
    double slope = 0.0;  ///< of it by L; the power is convex, so that it grows at least so fast
  };
  std::vector<Power> powers_;    ///< of each tour
  std::vector<double> lengths_;  ///< before the ruin
  std::vector<Power> old_powers_;
  std::vector<int> cut_tours_;  ///< by this ruin
  std::vector<Removal> removed_;
  std::vector<int> waiting_;  ///< cities to put back, in order
  std::vector<double> to_depot_;
  std::vector<int> cities_;  ///< those of the fleet but the depot, in any order
};

}  // namespace imslam::routing

#pragma once

#include <cstdint>
#include <vector>

namespace imslam::routing {

/// A closed tour through the places 0 ... n - 1, as an array, with the two changes of which all
/// others consist, and a log of them to go back by.
///
///   exchange   ... a b ... c d ...          ->  ... a c ... b d ...           2-opt, turns b ... c
///   swap       ... a b .. c d .. e f ...    ->  ... a d .. e b .. c f ...     Or-3opt, turns
///   nothing
class TourArray {
 public:
  explicit TourArray(std::vector<std::int32_t> order);

  int count() const { return static_cast<int>(order_.size()); }
  const std::vector<std::int32_t>& order() const { return order_; }
  int at(int position) const { return order_[static_cast<std::size_t>(wrapped(position))]; }
  int position(int place) const { return position_[static_cast<std::size_t>(place)]; }
  int next(int place) const { return at(position(place) + 1); }
  int previous(int place) const { return at(position(place) - 1); }
  /// Whether b comes before c (or is it) on the way on from a.
  bool between(int a, int b, int c) const { return steps(a, b) <= steps(a, c); }
  int steps(int from, int to) const { return wrapped(position(to) - position(from)); }

  /// a, b and c, d are neighbours, b after a and d after c, or both before: the tour may have been
  /// turned around as a whole in the meantime. Same below.
  void exchange(int a, int b, int c, int d);
  void swap_segments(int a, int b, int c, int d, int e, int f);

  void forget() { log_.clear(); }
  void go_back();  ///< undoes all since forget()

 private:
  struct Change {
    bool swap;
    int a, b, c, d, e, f;
  };
  int wrapped(int position) const {
    if (position < 0) return position + count();
    return position < count() ? position : position - count();
  }
  void put(int position, int place) {
    const int p = wrapped(position);
    order_[static_cast<std::size_t>(p)] = place;
    position_[static_cast<std::size_t>(place)] = p;
  }
  void turn(int from, int to);
  void apply_exchange(int a, int b, int c, int d);
  void apply_swap(int a, int b, int c, int d, int e, int f);
  void swap_neighbours(int first, int middle, int length);

  std::vector<std::int32_t> order_;
  std::vector<std::int32_t> position_;
  std::vector<std::int32_t> buffer_;
  std::vector<Change> log_;
};

}  // namespace imslam::routing

#include "slam/plugins/routing/tour_array.hpp"

#include <algorithm>
#include <utility>

namespace imslam::routing {

TourArray::TourArray(std::vector<std::int32_t> order)
    : order_(std::move(order)), position_(order_.size()) {
  for (int p = 0; p < count(); ++p) put(p, order_[static_cast<std::size_t>(p)]);
}

void TourArray::exchange(int a, int b, int c, int d) {
  apply_exchange(a, b, c, d);
  log_.push_back({false, a, b, c, d, 0, 0});
}

void TourArray::swap_segments(int a, int b, int c, int d, int e, int f) {
  apply_swap(a, b, c, d, e, f);
  log_.push_back({true, a, b, c, d, e, f});
}

void TourArray::go_back() {
  for (auto change = log_.rbegin(); change != log_.rend(); ++change) {
    const auto& [swap, a, b, c, d, e, f] = *change;
    if (swap) {
      apply_swap(a, d, e, b, c, f);
    } else {
      apply_exchange(a, c, b, d);
    }
  }
  log_.clear();
}

void TourArray::apply_exchange(int a, int b, int c, int d) {
  if (next(a) == b && next(c) == d) {
    turn(b, c);
  } else {
    turn(c, b);
  }
}

/// Turns around what lies between, or all the rest, which is the same tour.
void TourArray::turn(int from, int to) {
  const int inner = steps(from, to) + 1;
  int low = position(from);
  int high = position(to);
  int length = inner;
  if (2 * inner > count()) {
    std::swap(low, high);
    ++low;
    --high;
    length = count() - inner;
  }
  for (int k = 0; k < length / 2; ++k, ++low, --high) {
    low = wrapped(low);
    high = wrapped(high);
    const int first = at(low);
    put(low, at(high));
    put(high, first);
  }
}

void TourArray::apply_swap(int a, int b, int c, int d, int e, int f) {
  if (next(a) != b || next(c) != d) {  // turned around: f e .. d c .. b a
    std::swap(a, f);
    std::swap(b, e);
    std::swap(c, d);
  }
  const int left = steps(b, c) + 1;
  const int right = steps(d, e) + 1;
  const int rest = count() - left - right;
  // Of three segments in a circle any two may change places.
  if (rest >= left && rest >= right) return swap_neighbours(position(b), left, left + right);
  if (left >= right) return swap_neighbours(position(d), right, right + rest);
  swap_neighbours(position(f), rest, rest + left);
}

/// The first `middle` places from `first` on change sides with the rest of `length`.
void TourArray::swap_neighbours(int first, int middle, int length) {
  buffer_.resize(static_cast<std::size_t>(length));
  for (int k = 0; k < length; ++k) {
    const int target = k < middle ? k + length - middle : k - middle;
    buffer_[static_cast<std::size_t>(target)] = at(wrapped(first + k));
  }
  for (int k = 0; k < length; ++k) put(wrapped(first + k), buffer_[static_cast<std::size_t>(k)]);
}

}  // namespace imslam::routing

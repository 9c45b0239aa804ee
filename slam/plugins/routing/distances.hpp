#pragma once

#include <cstdint>
#include <vector>

#include "slam/plugins/routing/instance.hpp"

namespace imslam::routing {

/// Distances among some cities of an instance, which are numbered 0 ... n - 1 in the order given: a
/// table of floats up to kTableCities of them, else from the coordinates each time. For searches;
/// lengths that are reported come from Instance::distance. The instance must outlive it.
class Distances {
 public:
  static constexpr int kTableCities = 3000;  ///< 36 MB

  Distances(const Instance& instance, std::vector<int> cities, bool symmetric);
  explicit Distances(const Instance& instance);  ///< among all cities, under their own numbers

  int count() const { return static_cast<int>(cities_.size()); }
  int city(int i) const { return cities_[static_cast<std::size_t>(i)]; }
  const Instance& instance() const { return instance_; }
  bool symmetric() const { return symmetric_; }

  double operator()(int from, int to) const {
    if (table_.empty()) return from_coordinates(from, to);
    return table_[static_cast<std::size_t>(from) * cities_.size() + static_cast<std::size_t>(to)];
  }
  /// From one place to all others; null where there is no table.
  const float* row(int from) const {
    if (table_.empty()) return nullptr;
    return table_.data() + static_cast<std::size_t>(from) * cities_.size();
  }

 private:
  double from_coordinates(int from, int to) const {
    return instance_.distance(cities_[static_cast<std::size_t>(from)],
                              cities_[static_cast<std::size_t>(to)]);
  }

  const Instance& instance_;
  std::vector<int> cities_;
  bool symmetric_;
  std::vector<float> table_;
};

/// The nearest `count` others of each place, nearest first; if one way is shorter than the other,
/// near is whence it is not far. Fewer where there are not as many.
class Neighbours {
 public:
  Neighbours(const Distances& distances, int count);

  struct Row {
    const std::int32_t* first;
    const std::int32_t* last;
    const std::int32_t* begin() const { return first; }
    const std::int32_t* end() const { return last; }
  };

  int count() const { return count_; }
  Row of(int place) const {
    const std::int32_t* const first =
        places_.data() + static_cast<std::size_t>(place) * static_cast<std::size_t>(count_);
    return {first, first + count_};
  }

 private:
  int count_;
  std::vector<std::int32_t> places_;
};

}  // namespace imslam::routing

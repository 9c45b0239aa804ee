#pragma once

#include <cstdint>
#include <vector>

#include "slam/plugins/routing/distances.hpp"

namespace imslam::routing {

/// The tours of all agents as rings of nodes, for searches that take cities out and put them in
/// elsewhere in constant time.
///
///   node i < n       city i (place i of the distances, which hold all cities)
///   node n + t       the depot as tour t sees it; alone in its ring if the agent stays at home
class Fleet {
 public:
  Fleet(const Distances& distances, int depot, int agents);

  int agents() const { return static_cast<int>(lengths_.size()); }
  int cities() const { return distances_->count(); }
  int depot() const { return depot_; }
  const Distances& distances() const { return *distances_; }
  int home(int tour) const { return cities() + tour; }
  bool is_home(int node) const { return node >= cities(); }
  int place(int node) const { return is_home(node) ? depot_ : node; }

  int next(int node) const { return nodes_[index(node)].next; }
  int previous(int node) const { return nodes_[index(node)].previous; }
  int tour_of(int node) const { return nodes_[index(node)].tour; }      ///< -1: in none
  double onward(int node) const { return nodes_[index(node)].onward; }  ///< to the next
  double length(int tour) const { return lengths_[index(tour)]; }
  const std::vector<double>& lengths() const { return lengths_; }
  int longest() const;
  int size(int tour) const { return sizes_[index(tour)]; }  ///< cities

  /// What the tour grows by if `city` comes after `node`.
  double detour(int city, int node) const {
    const int to = place(next(node));
    const int from = place(node);
    const double there =
        distances_->symmetric() ? (*distances_)(city, from) : (*distances_)(from, city);
    return there + (*distances_)(city, to) - onward(node);
  }

  void insert(int city, int node);  ///< after the node; the city is in no tour
  int remove(int city);             ///< returns the node that it came after

  /// Lists of cities in visiting order, the depot left out.
  std::vector<std::vector<int>> tours() const;
  std::vector<int> tour(int number) const;
  /// Cities already in other tours leave them.
  void set_tour(int number, const std::vector<int>& cities);

  /// Lengths are added to and taken from: this clears what rounding has left.
  void sum_up_lengths();
  void restore_lengths(const std::vector<double>& lengths) { lengths_ = lengths; }

 private:
  struct Node {
    std::int32_t next = -1;
    std::int32_t previous = -1;
    std::int32_t tour = -1;
    float onward = 0.0F;  ///< distance to the next
  };
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  double edge(int from, int to) const { return (*distances_)(place(from), place(to)); }
  void link(int from, int to);

  const Distances* distances_;
  int depot_;
  std::vector<Node> nodes_;
  std::vector<double> lengths_;
  std::vector<std::int32_t> sizes_;
};

}  // namespace imslam::routing

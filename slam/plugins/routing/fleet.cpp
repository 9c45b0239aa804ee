#include "slam/plugins/routing/fleet.hpp"

#include <algorithm>

#include "slam/base/error.hpp"

namespace imslam::routing {

Fleet::Fleet(const Distances& distances, int depot, int agents)
    : distances_(&distances), depot_(depot) {
  expects(agents > 0 && depot >= 0 && depot < distances.count(), "Fleet: an agent and a depot");
  const std::size_t nodes = index(distances.count() + agents);
  nodes_.resize(nodes);
  lengths_.assign(index(agents), 0.0);
  sizes_.assign(index(agents), 0);
  for (int t = 0; t < agents; ++t) {
    nodes_[index(home(t))].tour = t;
    link(home(t), home(t));
  }
}

void Fleet::link(int from, int to) {
  nodes_[index(from)].next = to;
  nodes_[index(to)].previous = from;
  nodes_[index(from)].onward = static_cast<float>(edge(from, to));
}

int Fleet::longest() const {
  return static_cast<int>(std::max_element(lengths_.begin(), lengths_.end()) - lengths_.begin());
}

void Fleet::insert(int city, int node) {
  const int tour = tour_of(node);
  const int after = next(node);
  lengths_[index(tour)] += detour(city, node);
  sizes_[index(tour)] += 1;
  nodes_[index(city)].tour = tour;
  link(node, city);
  link(city, after);
}

int Fleet::remove(int city) {
  const int tour = tour_of(city);
  const int before = previous(city);
  const double old = onward(before) + onward(city);
  link(before, next(city));
  lengths_[index(tour)] += onward(before) - old;
  sizes_[index(tour)] -= 1;
  nodes_[index(city)].tour = -1;
  return before;
}

std::vector<int> Fleet::tour(int number) const {
  std::vector<int> cities;
  for (int node = next(home(number)); !is_home(node); node = next(node)) cities.push_back(node);
  return cities;
}

std::vector<std::vector<int>> Fleet::tours() const {
  std::vector<std::vector<int>> tours;
  for (int t = 0; t < agents(); ++t) tours.push_back(tour(t));
  return tours;
}

void Fleet::set_tour(int number, const std::vector<int>& cities) {
  for (const int city : tour(number)) remove(city);
  int last = home(number);
  for (const int city : cities) {
    if (tour_of(city) >= 0) remove(city);
    insert(city, last);
    last = city;
  }
}

void Fleet::sum_up_lengths() {
  for (int t = 0; t < agents(); ++t) {
    double length = onward(home(t));
    for (int node = next(home(t)); !is_home(node); node = next(node)) {
      length += onward(node);
    }
    lengths_[index(t)] = length;
  }
}

}  // namespace imslam::routing

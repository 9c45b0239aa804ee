#include "slam/plugins/routing/solution.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "slam/base/error.hpp"
#include "slam/plugins/routing/tour_solver.hpp"

namespace imslam::routing {

double Solution::longest() const {
  return lengths.empty() ? 0.0 : *std::max_element(lengths.begin(), lengths.end());
}

double Solution::total() const { return std::accumulate(lengths.begin(), lengths.end(), 0.0); }

Solution measured(const Instance& instance, std::vector<std::vector<int>> tours) {
  std::vector<char> seen(static_cast<std::size_t>(instance.city_count()), 0);
  seen.at(static_cast<std::size_t>(instance.depot)) = 1;
  Solution solution;
  for (const std::vector<int>& tour : tours) {
    std::vector<int> closed = {instance.depot};
    for (const int city : tour) {
      char& mark = seen.at(static_cast<std::size_t>(city));
      expects(mark == 0, "measured: a city is visited twice");
      mark = 1;
      closed.push_back(city);
    }
    solution.lengths.push_back(tour.empty() ? 0.0 : tour_length(instance, closed));
  }
  expects(std::find(seen.begin(), seen.end(), 0) == seen.end(), "measured: a city is left out");
  solution.tours = std::move(tours);
  return solution;
}

}  // namespace imslam::routing

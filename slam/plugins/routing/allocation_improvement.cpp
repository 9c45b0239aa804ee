#include "slam/plugins/routing/allocation_improvement.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/plugins/routing/allocate.hpp"
#include "slam/plugins/routing/min_max_search.hpp"

namespace imslam::routing {
namespace {

constexpr int kNear = 12;  ///< cities that each may be put next to
// Little: the network's answer is to be bettered, not replaced.
constexpr double kHot = 0.3;
constexpr double kCold = 0.03;

/// One tour search per agent, the depot left out.
Fleet first_fleet(const Distances& distances,
                  const Instance& instance,
                  const std::vector<std::vector<int>>& shares) {
  Fleet fleet(distances, instance.depot, static_cast<int>(shares.size()));
  for (std::size_t agent = 0; agent < shares.size(); ++agent) {
    std::vector<int> tour = solve_tour(instance, distances.symmetric(), shares[agent]);
    tour.erase(tour.begin());
    fleet.set_tour(static_cast<int>(agent), tour);
  }
  return fleet;
}

}  // namespace

SolveReport AllocationImprovement::solve(const learner::Vector& z) {
  z_ = z;
  const Instance& instance = problem_.instance();
  const learner::Vector x = likeliest_allocation(z, problem_.agents());
  const std::vector<int> first(x.begin(), x.end());
  const Distances distances(instance);
  const Neighbours near(distances, kNear);
  Fleet fleet = first_fleet(distances, instance, shares_of(instance, first, problem_.agents()));
  const double unit = mean_edge_per_agent(fleet);
  MinMaxSearch search(std::move(fleet), near, MinMaxOptions(), Random(1));
  SolveReport report;
  report.initial_cost = search.best().length(search.best().longest());
  const auto iterations = static_cast<std::int64_t>(std::ceil(effort_ * instance.city_count()));
  search.anneal(iterations, kHot * unit, kCold * unit);
  agent_of_.clear();
  for (int city = 0; city < instance.city_count(); ++city) {
    if (city != instance.depot) agent_of_.push_back(search.best().tour_of(city));
  }
  report.cost = search.best().length(search.best().longest());
  report.converged = true;  // as far as a search without slope can be
  report.iterations = static_cast<int>(iterations);
  report.reason = "end of the iterations";
  return report;
}

learner::UpperValue AllocationImprovement::upper_cost() const {
  learner::Matrix slope = allocation_probabilities(z_, problem_.agents());
  const double share = 1.0 / static_cast<double>(slope.rows());
  learner::UpperValue value;
  for (Eigen::Index i = 0; i < slope.rows(); ++i) {
    double& probability = slope(i, agent_of_[static_cast<std::size_t>(i)]);
    value.cost -= share * std::log(std::max(probability, 1e-300));
    probability -= 1.0;
  }
  const learner::Matrix by_agent = share * slope.transpose();
  value.by_z = Eigen::Map<const learner::Vector>(by_agent.data(), by_agent.size());
  return value;
}

}  // namespace imslam::routing

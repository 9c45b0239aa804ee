#include "slam/plugins/routing/routing_solver.hpp"

#include <fmt/format.h>

#include <optional>

#include "slam/base/error.hpp"
#include "slam/base/parallel.hpp"
#include "slam/plugins/routing/allocate.hpp"
#include "slam/plugins/routing/allocation_problem.hpp"
#include "slam/plugins/routing/chained_search.hpp"
#include "slam/plugins/routing/tour_solver.hpp"

namespace imslam::routing {
namespace {

using Tours = std::vector<std::vector<int>>;

constexpr int kNear = 16;              ///< cities that each may be put next to
constexpr double kSearchShare = 0.97;  ///< of the time; the rest is for the last polish

std::vector<int> without_depot(std::vector<int> tour) {
  tour.erase(tour.begin());
  return tour;
}

std::vector<int> with_depot(int depot, const std::vector<int>& tour) {
  std::vector<int> closed = {depot};
  closed.insert(closed.end(), tour.begin(), tour.end());
  return closed;
}

/// All agents' tours side by side.
template <typename Solve>
Tours tour_by_tour(const Tours& shares, const Solve& solve_one) {
  Tours tours(shares.size());
  parallel_for(shares.size(),
               [&](std::size_t agent) { tours[agent] = without_depot(solve_one(shares[agent])); });
  return tours;
}

Solution by_network(const Instance& instance,
                    const SolveOptions& options,
                    const AllocationNetwork<float>& network) {
  const learner::Vector z = allocation_logits(network, instance);
  AllocationProblem problem(options.agents);
  problem.set_instance(instance);
  Random random(static_cast<std::uint64_t>(options.seed));
  const bool symmetric = instance.symmetric();
  std::optional<Solution> best;
  for (int draw = 0; draw <= options.draws; ++draw) {
    const learner::Vector x =
        draw == 0 ? likeliest_allocation(z, options.agents) : problem.draw(z, random);
    const std::vector<int> agent_of(x.begin(), x.end());
    Solution solution =
        measured(instance, tour_by_tour(shares_of(instance, agent_of, options.agents),
                                        [&](const std::vector<int>& share) {
                                          return solve_tour(instance, symmetric, share);
                                        }));
    if (!best || solution.longest() < best->longest()) best = std::move(solution);
  }
  return *best;
}

Tours polished(const Instance& instance, bool symmetric, const Tours& tours, double kicks) {
  Tours closed;
  for (const std::vector<int>& tour : tours) closed.push_back(with_depot(instance.depot, tour));
  return tour_by_tour(closed, [&](const std::vector<int>& tour) {
    return polish_tour(instance, symmetric, tour, kicks);
  });
}

Tours inserted(const Distances& distances, const Neighbours& near, const SolveOptions& options) {
  Fleet fleet(distances, distances.instance().depot, options.agents);
  return MinMaxSearch::greedy(std::move(fleet), near).tours();
}

/// From insertion or from the network's likeliest allocation, whichever is better.
Tours by_search(const Instance& instance,
                const SolveOptions& options,
                const StopRule& stop,
                const AllocationNetwork<float>* network) {
  const Distances distances(instance);
  const Neighbours near(distances, kNear);
  Tours first = inserted(distances, near, options);
  if (options.method == Method::kInsertion) return first;
  first = polished(instance, distances.symmetric(), first, 0.0);
  MinMaxOptions search_options;
  search_options.heat = options.heat;
  if (network != nullptr) {
    SolveOptions likeliest = options;
    likeliest.draws = 0;
    Solution start = by_network(instance, likeliest, *network);
    if (start.longest() < measured(instance, first).longest()) {
      first = std::move(start.tours);
      search_options.heat = options.network_heat;
    }
  }
  Fleet fleet(distances, instance.depot, options.agents);
  for (int t = 0; t < options.agents; ++t) fleet.set_tour(t, first[static_cast<std::size_t>(t)]);
  ChainedSearch search(fleet, near, search_options, options.chains,
                       Random(static_cast<std::uint64_t>(options.seed)));
  search.run(stop.part(kSearchShare));
  return polished(instance, distances.symmetric(), search.best().tours(), 0.0);
}

Solution one_agent(const Instance& instance, const SolveOptions& options, const StopRule& stop) {
  std::vector<int> cities = {instance.depot};
  for (int city = 0; city < instance.city_count(); ++city) {
    if (city != instance.depot) cities.push_back(city);
  }
  Random random(static_cast<std::uint64_t>(options.seed));
  return measured(
      instance, {without_depot(solve_tour(instance, instance.symmetric(), cities, stop, random))});
}

void expect_network(const Instance& instance,
                    const SolveOptions& options,
                    const AllocationNetwork<float>* network) {
  if (network == nullptr || network->agents != options.agents) {
    throw InputError(
        fmt::format(
            "there is no network for {} agents; train one with `imslam route train --agents "
            "{}` and give it with --weights, or use --method search",
            options.agents, options.agents),
        ExitCode::kUsage);
  }
  if (instance.points.empty()) {
    throw InputError("the network needs coordinates, and a table has none; use --method search",
                     ExitCode::kUsage);
  }
}

}  // namespace

const std::vector<std::string>& method_names() {
  static const std::vector<std::string> names = {"insertion", "network", "search",
                                                 "network_search"};
  return names;
}

void SolveOptions::validate() const {
  const auto fail = [](const std::string& what) { throw InputError(what, ExitCode::kUsage); };
  if (agents < 1 || agents > 1000) fail(fmt::format("agents: expected 1 to 1000, got {}", agents));
  if (!(time_s >= 0.0) || time_s > 1e6) {
    fail(fmt::format("time: expected 0 to 1e6 seconds, got {}", time_s));
  }
  if (iterations < 0) fail(fmt::format("iterations: expected 0 or more, got {}", iterations));
  if (time_s == 0.0 && iterations == 0) fail("a search needs --time or --iterations");
  if (chains < 1 || chains > 1000) fail(fmt::format("chains: expected 1 to 1000, got {}", chains));
  if (!(heat > 0.0)) fail(fmt::format("heat: expected more than 0, got {}", heat));
  if (!(network_heat > 0.0))
    fail(fmt::format("network heat: expected more than 0, got {}", network_heat));
  if (draws < 0 || draws > 10000) fail(fmt::format("draws: expected 0 to 10000, got {}", draws));
}

Solution solve(const Instance& instance,
               const SolveOptions& options,
               const AllocationNetwork<float>* network) {
  options.validate();
  const StopRule stop = StopRule::of(options.time_s, options.iterations, options.time_of);
  const bool asks_network =
      options.method == Method::kNetwork || options.method == Method::kNetworkSearch;
  if (asks_network) expect_network(instance, options, network);
  if (options.agents == 1) return one_agent(instance, options, stop);
  if (options.method == Method::kNetwork) return by_network(instance, options, *network);
  return measured(instance, by_search(instance, options, stop, asks_network ? network : nullptr));
}

}  // namespace imslam::routing

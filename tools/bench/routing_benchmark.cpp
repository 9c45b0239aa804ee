// The searches of the routing plugin with other settings than the shipped ones, and the lower level
// alone. Random instances as in `imslam route bench`: uniform cities, random depot.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <chrono>
#include <numeric>

#include "slam/base/parallel.hpp"
#include "slam/plugins/routing/chained_search.hpp"
#include "slam/plugins/routing/tour_solver.hpp"

namespace {

using namespace imslam::routing;

struct Settings {
  int agents = 10;
  int cities = 1000;
  int instances = 5;
  double time_s = 1.0;
  int iterations = 0;
  int near = 16;
  int threads = 1;
  int chains = 1;
  int seed = 1;
  MinMaxOptions search;
};

Instance numbered(const Settings& settings, int cities, int index) {
  imslam::Random random = imslam::Random(static_cast<std::uint64_t>(settings.seed))
                              .fork(static_cast<std::uint64_t>(index));
  return random_instance(cities, random);
}

void measure_search(const Settings& settings) {
  double longest = 0.0;
  double iterations = 0.0;
  for (int i = 0; i < settings.instances; ++i) {
    const Instance instance = numbered(settings, settings.cities, i);
    const Distances distances(instance);
    const Neighbours near(distances, settings.near);
    Fleet fleet(distances, 0, settings.agents);
    ChainedSearch search(MinMaxSearch::greedy(std::move(fleet), near), near, settings.search,
                         settings.chains, imslam::Random(1));
    search.run(StopRule::of(settings.iterations > 0 ? 0.0 : settings.time_s, settings.iterations,
                            TimeOf::kProcessor));
    longest += search.best().length(search.best().longest()) / settings.instances;
    iterations += static_cast<double>(search.iterations()) / settings.instances;
  }
  fmt::print("search: mean longest {:.4f}, {:.0f} iterations/s\n", longest,
             iterations / settings.time_s);
}

void measure_tour(const Settings& settings) {
  const int size = settings.cities / settings.agents;
  double fast = 0.0, seconds = 0.0, slow = 0.0;
  for (int i = 0; i < settings.instances; ++i) {
    const Instance instance = numbered(settings, size, i);
    std::vector<int> cities(static_cast<std::size_t>(size));
    std::iota(cities.begin(), cities.end(), 0);
    const auto start = std::chrono::steady_clock::now();
    fast += tour_length(instance, solve_tour(instance, true, cities));
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    imslam::Random random(1);
    slow += tour_length(
        instance, solve_tour(instance, true, cities, StopRule::of(settings.time_s, 0), random));
  }
  fmt::print("one tour of {} cities: {:.2f} ms, {:.2f} % longer than after {} s more\n", size,
             1e3 * seconds / settings.instances, 100.0 * (fast / slow - 1.0), settings.time_s);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Searches of the routing plugin");
  app.add_option("--agents", settings.agents);
  app.add_option("--cities", settings.cities);
  app.add_option("--instances", settings.instances);
  app.add_option("--time", settings.time_s);
  app.add_option("--iterations", settings.iterations, "Of the search, instead of the time");
  app.add_option("--near", settings.near);
  app.add_option("--removed", settings.search.removed);
  app.add_option("--string", settings.search.longest_string);
  app.add_option("--attack", settings.search.attack);
  app.add_option("--blink", settings.search.blink);
  app.add_option("--heat", settings.search.heat);
  app.add_option("--cold", settings.search.cold);
  app.add_option("--chains", settings.chains);
  app.add_option("--threads", settings.threads);
  app.add_option("--seed", settings.seed, "Of the instances");
  bool lower = false;
  app.add_flag("--lower", lower, "Also the lower level");
  CLI11_PARSE(app, argc, argv);
  imslam::set_thread_count(settings.threads);
  measure_search(settings);
  if (lower) measure_tour(settings);
  return 0;
}

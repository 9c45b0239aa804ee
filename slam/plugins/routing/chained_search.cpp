#include "slam/plugins/routing/chained_search.hpp"

#include <algorithm>
#include <cmath>

#include "slam/base/parallel.hpp"

namespace imslam::routing {
namespace {

constexpr std::int64_t kRounds = 100;  ///< between which chains may exchange
constexpr std::int64_t kRoundsPerExchange = 4;
constexpr std::int64_t kFirstRound = 64;  ///< iterations, as long as the pace is not known

}  // namespace

ChainedSearch::ChainedSearch(const Fleet& start,
                             const Neighbours& near,
                             const MinMaxOptions& options,
                             int chains,
                             const Random& random)
    : options_(options), edge_(mean_edge_per_agent(start)) {
  for (int c = 0; c < std::max(1, chains); ++c) {
    chains_.emplace_back(start, near, options, random.fork(static_cast<std::uint64_t>(c)));
  }
}

const Fleet& ChainedSearch::best() const {
  const auto longest = [](const MinMaxSearch& chain) {
    return chain.best().length(chain.best().longest());
  };
  return std::min_element(
             chains_.begin(), chains_.end(),
             [&](const MinMaxSearch& a, const MinMaxSearch& b) { return longest(a) < longest(b); })
      ->best();
}

void ChainedSearch::exchange() {
  const auto best = std::min_element(chains_.begin(), chains_.end(),
                                     [](const MinMaxSearch& a, const MinMaxSearch& b) {
                                       return a.sum_of_powers() < b.sum_of_powers();
                                     });
  for (MinMaxSearch& chain : chains_) {
    if (&chain != &*best) chain.go_on_from(*best);
  }
}

std::int64_t ChainedSearch::first_round(const StopRule& stop) const {
  if (stop.has_clock()) return kFirstRound;
  return std::max<std::int64_t>(1, stop.iterations() / kRounds);
}

void ChainedSearch::run(const StopRule& stop) {
  const auto temperature = [&](double progress) {
    return edge_ * options_.heat * std::pow(options_.cold / options_.heat, std::min(progress, 1.0));
  };
  std::int64_t length = first_round(stop);
  double before = stop.progress(0);
  double step = 1.0 / kRounds;
  for (std::int64_t round = 1; before < 1.0; ++round) {
    parallel_for(chains_.size(), [&](std::size_t c) {
      chains_[c].anneal(length, temperature(before), temperature(before + step));
    });
    iterations_ += length;
    const double after = stop.progress(iterations_);
    step = std::max(after - before, 1e-9);
    if (stop.has_clock()) {  // rounds that take their share of the time, if the pace is even
      const double pace = static_cast<double>(length) / step;
      length = std::max<std::int64_t>(1, std::llround(pace * std::min(1.0 / kRounds, 1.0 - after)));
    }
    if (chains_.size() > 1 && round % kRoundsPerExchange == 0) exchange();
    before = after;
  }
}

}  // namespace imslam::routing

#include "slam/plugins/routing/min_max_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"

namespace imslam::routing {
namespace {

constexpr int kPower = 12;
constexpr int kBetweenCoolings = 64;
constexpr int kBetweenSums = 8192;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace

double mean_edge_per_agent(const Fleet& fleet) {
  double total = 0.0;  // not the longest alone, which a bad start may have made very long
  for (const double length : fleet.lengths()) total += length;
  return total / fleet.cities() / fleet.agents();
}

MinMaxSearch::MinMaxSearch(Fleet start,
                           const Neighbours& near,
                           const MinMaxOptions& options,
                           Random random)
    : fleet_(std::move(start)),
      best_(fleet_),
      near_(&near),
      options_(options),
      random_(std::move(random)) {
  const Distances& distances = fleet_.distances();
  for (int city = 0; city < fleet_.cities(); ++city) {
    to_depot_.push_back(distances(fleet_.depot(), city) + distances(city, fleet_.depot()));
    if (fleet_.tour_of(city) >= 0) cities_.push_back(city);
  }
  fleet_.sum_up_lengths();
  const double longest = fleet_.length(fleet_.longest());
  const double farthest = *std::max_element(to_depot_.begin(), to_depot_.end());
  unit_ = std::max({longest, farthest, 1e-300});
  powers_.resize(index(fleet_.agents()));
  for (int t = 0; t < fleet_.agents(); ++t) note_power(t);
  sum_ = sum_of_powers();
  best_longest_ = longest;
}

double MinMaxSearch::power(double length) const {
  const double x = length / unit_;
  const double x2 = x * x;
  const double x4 = x2 * x2;
  return x4 * x4 * x4;
}

double MinMaxSearch::sum_of_powers() const {
  double sum = 0.0;
  for (const Power& p : powers_) sum += p.value;
  return sum;
}

void MinMaxSearch::note_power(int tour) {
  const double length = fleet_.length(tour);
  const double value = power(length);
  powers_[index(tour)] = {value, length > 0.0 ? kPower * value / length : 0.0};
}

/// The place with the least growth of the sum; the node that the city is to come after.
int MinMaxSearch::best_place(int city, bool blink) {
  int best = -1;
  double least = 1e300;
  const float* const row = fleet_.distances().symmetric() ? fleet_.distances().row(city) : nullptr;
  const auto consider = [&](int node, int tour) {
    const double detour = row != nullptr ? double{row[fleet_.place(node)]} +
                                               double{row[fleet_.place(fleet_.next(node))]} -
                                               fleet_.onward(node)
                                         : fleet_.detour(city, node);
    const Power& now = powers_[index(tour)];
    if (now.slope * detour >= least) return;
    const double cost = power(fleet_.length(tour) + detour) - now.value;
    if (cost >= least) return;
    least = cost;
    best = node;
  };
  // Drawn once per city: draws would take longer than looking.
  const bool blinks = blink && random_.chance(options_.blink * near_->count());
  int overlooked = blinks ? static_cast<int>(random_.integer(0, near_->count() - 1)) : -1;
  for (const int other : near_->of(city)) {
    const int tour = fleet_.tour_of(other);
    if (overlooked-- == 0 || tour < 0) continue;  // the depot is in none
    consider(other, tour);
    consider(fleet_.previous(other), tour);
  }
  bool tried_empty = false;
  for (int t = 0; t < fleet_.agents(); ++t) {
    const bool empty = fleet_.size(t) == 0;
    if (empty && tried_empty) continue;  // all that stay at home are alike
    tried_empty = tried_empty || empty;
    consider(fleet_.home(t), t);
    if (!empty) consider(fleet_.previous(fleet_.home(t)), t);
  }
  expects(best >= 0, "MinMaxSearch: distances must be finite and of ordinary size");
  return best;
}

Fleet MinMaxSearch::greedy(Fleet fleet, const Neighbours& near) {
  MinMaxSearch search(std::move(fleet), near, MinMaxOptions(), Random(0));
  for (int city = 0; city < search.fleet_.cities(); ++city) {
    if (city != search.fleet_.depot() && search.fleet_.tour_of(city) < 0) {
      search.waiting_.push_back(city);
    }
  }
  std::stable_sort(search.waiting_.begin(), search.waiting_.end(), [&](int a, int b) {
    return search.to_depot_[index(a)] > search.to_depot_[index(b)];
  });
  search.options_.blink = 0.0;
  search.recreate();
  return search.fleet_;
}

int MinMaxSearch::seed_city() {
  const auto last = static_cast<std::int64_t>(cities_.size()) - 1;
  const auto any = [&] { return cities_[static_cast<std::size_t>(random_.integer(0, last))]; };
  if (random_.chance(options_.attack)) {
    const int longest = fleet_.longest();
    // A few tries find a city of the longest tour; if not, any city will do.
    for (int tries = 0; tries < 2 * fleet_.agents(); ++tries) {
      const int city = any();
      if (fleet_.tour_of(city) == longest) return city;
    }
  }
  return any();
}

void MinMaxSearch::ruin() {
  const int seed = seed_city();
  const double mean_size = static_cast<double>(cities_.size()) / fleet_.agents();
  const double longest = std::max(1.0, std::min<double>(options_.longest_string, mean_size));
  const double most_strings = std::max(1.0, 4.0 * options_.removed / (1.0 + longest) - 1.0);
  int strings = static_cast<int>(random_.uniform(1.0, most_strings + 1.0));
  cut_tours_.clear();
  const auto cut = [&](int city) {
    cut_tours_.push_back(fleet_.tour_of(city));
    const double limit = std::min<double>(longest, fleet_.size(fleet_.tour_of(city)));
    remove_string(city, static_cast<int>(random_.uniform(1.0, limit + 1.0)));
    --strings;
  };
  cut(seed);
  for (const int city : near_->of(seed)) {
    if (strings <= 0) break;
    const int tour = fleet_.tour_of(city);
    const bool cut_before =
        std::find(cut_tours_.begin(), cut_tours_.end(), tour) != cut_tours_.end();
    if (tour >= 0 && !cut_before) cut(city);
  }
}

/// `length` neighbours on the tour, the city among them; now and then a few of a longer string
/// stay.
void MinMaxSearch::remove_string(int city, int length) {
  const int tour = fleet_.tour_of(city);
  int node = city;
  for (int back = static_cast<int>(random_.integer(0, length - 1)); back > 0; --back) {
    if (fleet_.is_home(fleet_.previous(node))) break;
    node = fleet_.previous(node);
  }
  int kept_from = -1;
  int kept = 0;
  if (length > 1 && fleet_.size(tour) > length && random_.chance(0.5)) {
    kept = 1;
    while (length + kept < fleet_.size(tour) && !random_.chance(0.5)) ++kept;
    kept_from = static_cast<int>(random_.integer(1, length - 1));
  }
  for (int k = 0; k < length && !fleet_.is_home(node); ++k) {
    for (int skip = k == kept_from ? kept : 0; skip > 0 && !fleet_.is_home(node); --skip) {
      node = fleet_.next(node);
    }
    if (fleet_.is_home(node)) break;
    const int next = fleet_.next(node);
    removed_.push_back({node, fleet_.remove(node)});
    node = next;
  }
  note_power(tour);
}

void MinMaxSearch::order_removed() {
  waiting_.clear();
  for (const Removal& removal : removed_) waiting_.push_back(removal.city);
  for (std::size_t i = waiting_.size(); i > 1; --i) {
    std::swap(
        waiting_[i - 1],
        waiting_[index(static_cast<int>(random_.integer(0, static_cast<std::int64_t>(i) - 1)))]);
  }
  const double choice = random_.uniform();
  const double sign = choice < 0.3 ? 1.0 : -1.0;  // far from the depot first, or near
  if (choice > 0.45) return;
  std::stable_sort(waiting_.begin(), waiting_.end(), [&](int a, int b) {
    return sign * to_depot_[index(a)] > sign * to_depot_[index(b)];
  });
}

void MinMaxSearch::recreate() {
  for (const int city : waiting_) {
    const int node = best_place(city, options_.blink > 0.0);
    fleet_.insert(city, node);
    note_power(fleet_.tour_of(city));
  }
  waiting_.clear();
}

void MinMaxSearch::rollback() {
  for (const Removal& removal : removed_) fleet_.remove(removal.city);
  for (auto removal = removed_.rbegin(); removal != removed_.rend(); ++removal) {
    fleet_.insert(removal->city, removal->previous);
  }
  fleet_.restore_lengths(lengths_);
  powers_ = old_powers_;
}

/// f' < f - T log u, where f = sum^(1/12) changes by f / (12 sum) times what the sum does.
bool MinMaxSearch::accepts(double sum, double temperature) {
  if (sum <= sum_) return true;
  const double f = unit_ * std::pow(sum_, 1.0 / kPower);
  const double slack = -temperature * std::log(1.0 - random_.uniform()) / f;
  return sum < sum_ * (1.0 + kPower * slack);
}

void MinMaxSearch::adopt(double sum) {
  sum_ = sum;
  const double longest = fleet_.length(fleet_.longest());
  if (longest >= best_longest_ * (1.0 - 1e-9)) return;
  best_longest_ = longest;
  best_ = fleet_;
}

void MinMaxSearch::go_on_from(const MinMaxSearch& other) {
  fleet_ = other.fleet_;
  powers_ = other.powers_;
  sum_ = other.sum_;
}

void MinMaxSearch::anneal(std::int64_t iterations, double hot, double cold) {
  if (cities_.size() < 2) return;
  double temperature = hot;
  for (std::int64_t i = 0; i < iterations; ++i) {
    if (i % kBetweenCoolings == 0) {
      const double share = static_cast<double>(i) / static_cast<double>(iterations);
      temperature = hot * std::pow(cold / hot, share);
    }
    if (i % kBetweenSums == 0) {
      fleet_.sum_up_lengths();
      for (int t = 0; t < fleet_.agents(); ++t) note_power(t);
      sum_ = sum_of_powers();
    }
    lengths_ = fleet_.lengths();
    old_powers_ = powers_;
    removed_.clear();
    ruin();
    order_removed();
    recreate();
    const double sum = sum_of_powers();
    if (accepts(sum, temperature)) {
      adopt(sum);
    } else {
      rollback();
    }
  }
}

}  // namespace imslam::routing

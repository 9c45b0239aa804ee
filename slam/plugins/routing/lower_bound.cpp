#include "slam/plugins/routing/lower_bound.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace imslam::routing {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// Edges cost d_ij + price_i + price_j; the depot has price 0.
class OneTree {
 public:
  OneTree(const Distances& distances, int depot, int special)
      : distances_(distances), depot_(depot), special_(special) {}

  /// Of the tree, less twice the prices; fills the degrees.
  double value(const std::vector<double>& price, std::vector<int>& degree) const {
    const int n = distances_.count();
    degree.assign(index(n), 0);
    std::vector<double> nearest(index(n), 1e300);
    std::vector<int> parent(index(n), depot_);
    std::vector<char> in_tree(index(n), 0);
    in_tree[index(depot_)] = in_tree[index(special_)] = 1;
    double sum = 0.0;
    int last = depot_;
    for (int k = 2; k < n; ++k) {
      int next = -1;
      for (int i = 0; i < n; ++i) {
        if (in_tree[index(i)] != 0) continue;
        const double cost = distances_(last, i) + price[index(last)] + price[index(i)];
        if (cost < nearest[index(i)]) {
          nearest[index(i)] = cost;
          parent[index(i)] = last;
        }
        if (next < 0 || nearest[index(i)] < nearest[index(next)]) next = i;
      }
      in_tree[index(next)] = 1;
      sum += nearest[index(next)];
      ++degree[index(next)];
      ++degree[index(parent[index(next)])];
      last = next;
    }
    sum += two_edges(price, degree);
    for (const double p : price) sum -= 2.0 * p;
    return sum;
  }

 private:
  double two_edges(const std::vector<double>& price, std::vector<int>& degree) const {
    std::vector<std::pair<double, int>> edges;
    for (int i = 0; i < distances_.count(); ++i) {
      if (i == special_) continue;
      const double cost = distances_(special_, i) + price[index(special_)] + price[index(i)];
      edges.emplace_back(cost, i);
      if (i == depot_) edges.emplace_back(cost, i);  // there and back
    }
    std::partial_sort(edges.begin(), edges.begin() + 2, edges.end());
    ++degree[index(edges[0].second)];
    ++degree[index(edges[1].second)];
    degree[index(special_)] = 2;
    return edges[0].first + edges[1].first;
  }

  const Distances& distances_;
  int depot_;
  int special_;
};

/// Subgradient ascent with steps that shrink geometrically.
double least_total(const Distances& distances, int depot, int steps) {
  const int n = distances.count();
  const OneTree tree(distances, depot, depot == 0 ? 1 : 0);
  std::vector<double> price(index(n), 0.0);
  std::vector<int> degree;
  double best = tree.value(price, degree);
  double step = best / n;
  for (int k = 0; k < steps; ++k, step *= 0.97) {
    for (int i = 0; i < n; ++i) {
      if (i != depot) price[index(i)] += step * (degree[index(i)] - 2);
    }
    best = std::max(best, tree.value(price, degree));
  }
  return best;
}

}  // namespace

LowerBound lower_bound(const Distances& distances, int depot, int agents, int steps) {
  LowerBound bound;
  if (distances.instance().metric == Metric::kEuclidean) {
    for (int i = 0; i < distances.count(); ++i) {
      bound.farthest = std::max(bound.farthest, distances(depot, i) + distances(i, depot));
    }
  }
  if (distances.symmetric() && distances.count() >= 3 &&
      distances.count() <= Distances::kTableCities) {
    bound.share = least_total(distances, depot, steps) / agents;
  }
  return bound;
}

}  // namespace imslam::routing

#include "slam/evaluation/associate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "slam/base/error.hpp"
#include "slam/evaluation/association_advice.hpp"
#include "slam/evaluation/rigid_matrix.hpp"

namespace imslam::evaluation {
namespace {

[[noreturn]] void fail(const std::string& message) {
  throw InputError(message, ExitCode::kEvaluation);
}

void append(PosePath& path, const PosePath& from, std::size_t index) {
  path.stamps_s.push_back(from.stamps_s[index]);
  path.poses.push_back(from.poses[index]);
}

PosePath named_like(const PosePath& path) {
  PosePath empty;
  empty.frame = path.frame;
  empty.source = path.source;
  return empty;
}

PosePath cropped(const PosePath& path, const AssociationOptions& options) {
  if (!path.has_stamps() || (!options.start_s && !options.end_s)) return path;
  PosePath result = named_like(path);
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (options.start_s && path.stamps_s[i] < *options.start_s) continue;
    if (options.end_s && path.stamps_s[i] > *options.end_s) continue;
    append(result, path, i);
  }
  if (result.size() == 0) {
    const auto [first, last] = std::minmax_element(path.stamps_s.begin(), path.stamps_s.end());
    fail(
        fmt::format("no reference pose between --t-start and --t-end; stamps run from {:.3f} to "
                    "{:.3f} s",
                    *first, *last));
  }
  return result;
}

MatchedPaths match_by_index(const PosePath& reference, const PosePath& estimate) {
  if (reference.size() != estimate.size()) {
    fail(
        fmt::format("trajectories must have same number of poses: {} has {}, {} has {}; without "
                    "time stamps pose i is compared with pose i",
                    reference.source, reference.size(), estimate.source, estimate.size()));
  }
  MatchedPaths matched;
  matched.reference = reference;
  matched.estimate = estimate;
  return matched;
}

/// evo's rule. Returns how many poses of the longer path serve more than once.
std::size_t match_nearest(const PosePath& reference,
                          const PosePath& estimate,
                          const AssociationOptions& options,
                          MatchedPaths& matched) {
  const bool estimate_is_longer = estimate.size() > reference.size();
  const PosePath& shorter = estimate_is_longer ? reference : estimate;
  const PosePath& longer = estimate_is_longer ? estimate : reference;
  const double offset_s = estimate_is_longer ? options.offset_s : -options.offset_s;
  const auto nearest = nearest_stamps(shorter.stamps_s, longer.stamps_s, offset_s);
  std::vector<int> uses(longer.size(), 0);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    if (!(nearest[i].difference_s <= options.max_difference_s)) continue;
    append(estimate_is_longer ? matched.reference : matched.estimate, shorter, i);
    append(estimate_is_longer ? matched.estimate : matched.reference, longer, nearest[i].index);
    ++uses[nearest[i].index];
  }
  return static_cast<std::size_t>(
      std::count_if(uses.begin(), uses.end(), [](int n) { return n > 1; }));
}

Eigen::Matrix4d between(const Eigen::Matrix4d& A, const Eigen::Matrix4d& B, double share) {
  const Eigen::Quaterniond q = quaternion_of(rotation(A)).slerp(share, quaternion_of(rotation(B)));
  return rigid(q.toRotationMatrix(), (1.0 - share) * position(A) + share * position(B));
}

/// Reference poses at the very stamps of the estimate: straight line and slerp in between.
void match_interpolated(const PosePath& reference,
                        const PosePath& estimate,
                        const AssociationOptions& options,
                        MatchedPaths& matched) {
  std::vector<std::size_t> order(reference.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto& stamps = reference.stamps_s;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return stamps[a] < stamps[b]; });
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const double stamp = estimate.stamps_s[i] + options.offset_s;
    const auto after = std::lower_bound(order.begin(), order.end(), stamp,
                                        [&](std::size_t a, double s) { return stamps[a] < s; });
    if (after == order.end()) continue;
    const std::size_t b = *after;
    const std::size_t a = stamps[b] == stamp || after == order.begin() ? b : *std::prev(after);
    const double gap = stamps[b] - stamps[a];
    if ((a == b && stamps[b] != stamp) || gap > options.max_gap_s) continue;
    const double share = a == b ? 0.0 : (stamp - stamps[a]) / gap;
    matched.reference.stamps_s.push_back(stamp);
    matched.reference.poses.push_back(
        a == b ? reference.poses[b] : between(reference.poses[a], reference.poses[b], share));
    append(matched.estimate, estimate, i);
  }
}

double duration(const std::vector<double>& stamps) {
  const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end());
  return *last - *first;
}

void measure_coverage(const PosePath& reference, const PosePath& estimate, MatchedPaths& matched) {
  const std::size_t possible = std::min(reference.size(), estimate.size());
  matched.reference_poses = reference.size();
  matched.estimate_poses = estimate.size();
  matched.coverage =
      std::min(1.0, static_cast<double>(matched.estimate.size()) / static_cast<double>(possible));
  matched.time_coverage = 1.0;
  if (!reference.has_stamps() || duration(reference.stamps_s) <= 0.0) return;
  matched.time_coverage =
      std::min(1.0, duration(matched.reference.stamps_s) / duration(reference.stamps_s));
}

}  // namespace

void AssociationOptions::validate() const {
  const auto require = [](bool condition, const std::string& message) {
    if (!condition) throw InputError(message, ExitCode::kUsage);
  };
  require(std::isfinite(max_difference_s) && max_difference_s >= 0.0,
          fmt::format("t-max-diff = {}: must not be negative", max_difference_s));
  require(std::isfinite(offset_s), fmt::format("t-offset = {}: must be finite", offset_s));
  require(max_gap_s > 0.0, fmt::format("max-gap = {}: must be greater than 0", max_gap_s));
  require(!start_s || !end_s || *start_s <= *end_s, "t-start must not lie after t-end");
}

std::vector<Nearest> nearest_stamps(const std::vector<double>& stamps,
                                    const std::vector<double>& others,
                                    double offset_s) {
  expects(!others.empty(), "nearest_stamps: others must not be empty");
  std::vector<std::size_t> order(others.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return others[a] < others[b]; });
  std::vector<Nearest> result;
  result.reserve(stamps.size());
  for (const double stamp : stamps) {
    // Rounding keeps order: the difference, computed as evo does, falls to a minimum and rises.
    const auto signed_gap = [&](std::size_t k) { return (others[order[k]] + offset_s) - stamp; };
    const auto begin = order.begin();
    const auto reached = std::partition_point(begin, order.end(), [&](std::size_t index) {
      return (others[index] + offset_s) - stamp < 0.0;
    });
    const auto k = static_cast<std::size_t>(reached - begin);
    double best = k < order.size() ? std::abs(signed_gap(k)) : std::abs(signed_gap(k - 1));
    if (k > 0) best = std::min(best, std::abs(signed_gap(k - 1)));
    std::size_t first = others.size();  // the lowest index among equally near ones
    for (std::size_t j = k; j < order.size() && std::abs(signed_gap(j)) == best; ++j) {
      first = std::min(first, order[j]);
    }
    for (std::size_t j = k; j-- > 0 && std::abs(signed_gap(j)) == best;) {
      first = std::min(first, order[j]);
    }
    result.push_back({first, best});
  }
  return result;
}

MatchedPaths associate(const PosePath& whole_reference,
                       const PosePath& estimate,
                       const AssociationOptions& options) {
  options.validate();
  if (whole_reference.size() == 0 || estimate.size() == 0) fail("a trajectory without poses");
  if (whole_reference.has_stamps() != estimate.has_stamps()) {
    const bool reference_has = whole_reference.has_stamps();
    fail(
        fmt::format("{} has time stamps and {} has none; give both as TUM or EuRoC, or both as "
                    "KITTI",
                    reference_has ? whole_reference.source : estimate.source,
                    reference_has ? estimate.source : whole_reference.source));
  }
  const PosePath reference = cropped(whole_reference, options);
  MatchedPaths matched;
  std::size_t reused = 0;
  if (!reference.has_stamps()) {
    matched = match_by_index(reference, estimate);
  } else {
    matched.reference = named_like(reference);
    matched.estimate = named_like(estimate);
    if (options.interpolate) {
      match_interpolated(reference, estimate, options, matched);
    } else {
      reused = match_nearest(reference, estimate, options, matched);
    }
    if (matched.estimate.size() == 0) {
      fail("found no matching timestamps: " + explain_mismatch(reference, estimate, options));
    }
  }
  measure_coverage(reference, estimate, matched);
  matched.warnings = association_warnings(reference, estimate, matched, reused, options);
  return matched;
}

}  // namespace imslam::evaluation

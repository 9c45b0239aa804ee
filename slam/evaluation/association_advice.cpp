#include "slam/evaluation/association_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace imslam::evaluation {
namespace {

constexpr double kEnough = 0.9;            ///< share of stamps that should match
constexpr double kLatestSecond = 1e11;     ///< [s], year 5138: no clock counts that far in seconds
constexpr double kUsefulDifference = 1.0;  ///< [s], larger bounds pair unrelated poses

struct Range {
  double first = 0.0;
  double last = 0.0;
};

Range range_of(const std::vector<double>& stamps) {
  const auto [first, last] = std::minmax_element(stamps.begin(), stamps.end());
  return {*first, *last};
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Unit {
  const char* name;
  double per_second;
};
constexpr std::array<Unit, 3> kUnits = {
    {{"nanoseconds", 1e9}, {"microseconds", 1e6}, {"milliseconds", 1e3}}};

/// The unit in which a path counts too large to be seconds since 1970.
std::optional<Unit> wrong_unit(const std::vector<double>& stamps) {
  const double stamp = std::abs(median_of(stamps));
  if (stamp < kLatestSecond) return std::nullopt;
  for (const Unit& unit : kUnits) {
    if (stamp / unit.per_second > 1e8) return unit;  // after 1973
  }
  return std::nullopt;
}

/// The unit that would turn one path's stamps into the other's, for clocks of any epoch.
std::optional<Unit> unit_between(const Range& large, const Range& small) {
  for (const Unit& unit : kUnits) {
    const Range scaled = {large.first / unit.per_second, large.last / unit.per_second};
    const double slack = 0.5 * (small.last - small.first);
    const bool overlap = scaled.first <= small.last + slack && scaled.last >= small.first - slack;
    if (overlap && large.last - large.first > 100.0 * (small.last - small.first)) return unit;
  }
  return std::nullopt;
}

std::string unit_sentence(const std::string& source, const Unit& unit) {
  return fmt::format("the stamps of {} look like {}, seconds were expected; divide them by {:.0e}",
                     source, unit.name, unit.per_second);
}

std::optional<std::string> unit_mismatch(const PosePath& reference, const PosePath& estimate) {
  const Range r = range_of(reference.stamps_s);
  const Range e = range_of(estimate.stamps_s);
  if (const auto unit = unit_between(r, e)) return unit_sentence(reference.source, *unit);
  if (const auto unit = unit_between(e, r)) return unit_sentence(estimate.source, *unit);
  for (const PosePath* path : {&reference, &estimate}) {
    if (const auto unit = wrong_unit(path->stamps_s)) return unit_sentence(path->source, *unit);
  }
  return std::nullopt;
}

/// The bound with which nine of ten poses of the shorter path would match [s], rounded up to two
/// digits.
double sufficient_difference(const PosePath& reference,
                             const PosePath& estimate,
                             const AssociationOptions& options) {
  const bool estimate_is_longer = estimate.size() > reference.size();
  const auto& shorter = estimate_is_longer ? reference.stamps_s : estimate.stamps_s;
  const auto& longer = estimate_is_longer ? estimate.stamps_s : reference.stamps_s;
  std::vector<double> differences;
  for (const Nearest& nearest :
       nearest_stamps(shorter, longer, estimate_is_longer ? options.offset_s : -options.offset_s)) {
    differences.push_back(nearest.difference_s);
  }
  const auto rank =
      static_cast<std::size_t>(std::ceil(kEnough * static_cast<double>(differences.size())) - 1.0);
  std::nth_element(differences.begin(), differences.begin() + static_cast<std::ptrdiff_t>(rank),
                   differences.end());
  const double needed = differences[rank];
  if (needed <= 0.0) return 0.0;
  const double digit = std::pow(10.0, std::floor(std::log10(needed)) - 1.0);
  return std::ceil(needed / digit) * digit;
}

std::string range_sentence(const char* name, const Range& range) {
  return fmt::format("{} runs from {:.3f} to {:.3f} s", name, range.first, range.last);
}

}  // namespace

std::string explain_mismatch(const PosePath& reference,
                             const PosePath& estimate,
                             const AssociationOptions& options) {
  if (const auto sentence = unit_mismatch(reference, estimate)) return *sentence;
  const Range r = range_of(reference.stamps_s);
  Range e = range_of(estimate.stamps_s);
  e.first += options.offset_s;
  e.last += options.offset_s;
  const std::string ranges =
      range_sentence("the reference", r) + ", " + range_sentence("the estimate", e);
  if (e.last < r.first || r.last < e.first) {
    return fmt::format(
        "{}: they do not overlap; if they show the same motion on two clocks, shift the estimate, "
        "e.g. --t-offset {:.6g}, else take the right file",
        ranges, r.first - e.first + options.offset_s);
  }
  if (options.interpolate) {
    return ranges + "; the reference has holes larger than the bound for interpolation";
  }
  const double needed = sufficient_difference(reference, estimate, options);
  if (needed > options.max_difference_s && needed <= kUsefulDifference) {
    return fmt::format(
        "stamps lie further apart than {:g} s (rounded?); --t-max-diff {:g} would "
        "match 90 % of them",
        options.max_difference_s, needed);
  }
  return ranges + "; much of the shorter one lies where the other has no poses";
}

std::vector<std::string> association_warnings(const PosePath& reference,
                                              const PosePath& estimate,
                                              const MatchedPaths& matched,
                                              std::size_t reused,
                                              const AssociationOptions& options) {
  std::vector<std::string> warnings;
  if (!reference.has_stamps()) return warnings;
  if (matched.coverage < kEnough) {
    warnings.push_back(
        fmt::format("only {} of {} poses ({:.1f} %) found a partner in time: {}",
                    matched.estimate.size(), std::min(reference.size(), estimate.size()),
                    100.0 * matched.coverage, explain_mismatch(reference, estimate, options)));
  } else if (const auto sentence = unit_mismatch(reference, estimate)) {
    warnings.push_back(*sentence);
  }
  if (matched.time_coverage < kEnough) {
    warnings.push_back(fmt::format(
        "the matched poses span only {:.1f} % of the reference's duration: errors of the missing "
        "part are not in the figures",
        100.0 * matched.time_coverage));
  }
  if (reused > 0) {
    warnings.push_back(fmt::format(
        "{} poses of {} serve as partner of more than one pose (evo counts them so too); check for "
        "repeated stamps or a lower rate, or use --interpolate",
        reused, estimate.size() > reference.size() ? estimate.source : reference.source));
  }
  return warnings;
}

}  // namespace imslam::evaluation

#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/chaos.hpp"
#include "tests/support/run_check.hpp"

namespace imslam::testing {

inline double root_mean_square(const std::vector<double>& errors) {
  double sum = 0.0;
  for (const double error : errors) sum += error * error;
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

/// The unspoiled runs of all five recordings.
inline std::vector<CheckedRun> clean_runs() {
  std::vector<CheckedRun> runs;
  for (const Recording& recording : simulated_base().recordings) {
    runs.emplace_back();
    expect_complete_run(recording.clean_run, runs.back());
  }
  return runs;
}

/// Errors of runs, none below the floor of error_ratio().
inline std::vector<double> floored_errors(const char* key, const std::vector<CheckedRun>& runs) {
  std::vector<double> errors;
  for (const CheckedRun& run : runs) errors.push_back(std::max(run.error_m(key), kErrorFloor_m));
  return errors;
}

/// What damage costs, from errors of the same recordings with and without it: the smaller of two
/// estimates, the ratio of all errors together and the median of the ratios. Luck makes the one too
/// large where one recording outweighs the rest, the other where unspoiled errors happen to be
/// small.
inline double cost_of_damage(const std::vector<double>& spoiled, const std::vector<double>& clean) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < clean.size(); ++i) ratios.push_back(spoiled[i] / clean[i]);
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return std::min(*middle, root_mean_square(spoiled) / root_mean_square(clean));
}

/// Spoils each of the five recordings with a seed of its own and holds what that costs against
/// `factor`. Returns the spoiled runs.
///
/// One ratio says little: the error of 5 m of path is mostly one of scale, and follows from the
/// disparity offset, which so short a recording tells to 0.01 px only; that alone moves an error of
/// 2 mm by a factor of two either way, damage or none, from processor to processor.
inline std::vector<CheckedRun> expect_pooled_error_within(
    double factor, const TempDir& dir, const std::function<void(Chaos&)>& spoil) {
  std::vector<CheckedRun> spoiled;
  std::uint64_t seed = 0;
  for (const Recording& recording : simulated_base().recordings) {
    const std::string number = std::to_string(++seed);
    Chaos chaos(recording.sequence, dir.path() / ("spoiled" + number), seed);
    spoil(chaos);
    spoiled.push_back(run_checked(dir, chaos.folder(), "", "run" + number));
    std::filesystem::remove_all(chaos.folder());
  }
  const std::vector<CheckedRun> clean = clean_runs();
  for (const char* key : kErrorKeys) {
    const double ratio = cost_of_damage(floored_errors(key, spoiled), floored_errors(key, clean));
    std::string all;
    for (std::size_t i = 0; i < clean.size(); ++i) {
      all +=
          fmt::format("{:.2f}/{:.2f} ", 1e3 * spoiled[i].error_m(key), 1e3 * clean[i].error_m(key));
    }
    ::testing::Test::RecordProperty(key, all);
    EXPECT_LE(ratio, factor) << key << ", spoiled/unspoiled [mm]: " << all;
  }
  return spoiled;
}

}  // namespace imslam::testing

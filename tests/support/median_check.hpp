#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/chaos.hpp"
#include "tests/support/run_check.hpp"

namespace imslam::testing {

/// Spoils each of the five recordings with a seed of its own and holds the median of the five
/// ratios of spoiled to unspoiled error against `factor`. Returns the spoiled runs.
///
/// One ratio says little: the error of 5 m of path is mostly one of scale, and follows from the
/// disparity offset, which so short a recording tells to 0.01 px only; that alone moves an error of
/// 2 mm by a factor of two either way, damage or none.
inline std::vector<CheckedRun> expect_median_error_within(
    double factor, const TempDir& dir, const std::function<void(Chaos&)>& spoil) {
  std::vector<CheckedRun> runs;
  std::array<std::vector<double>, kErrorKeys.size()> ratios;
  std::uint64_t seed = 0;
  for (const Recording& recording : simulated_base().recordings) {
    const std::string number = std::to_string(++seed);
    Chaos chaos(recording.sequence, dir.path() / ("spoiled" + number), seed);
    spoil(chaos);
    runs.push_back(run_checked(dir, chaos.folder(), "", "run" + number));
    CheckedRun clean;
    expect_complete_run(recording.clean_run, clean);
    for (std::size_t k = 0; k < ratios.size(); ++k) {
      ratios.at(k).push_back(error_ratio(kErrorKeys.at(k), runs.back(), clean));
    }
    std::filesystem::remove_all(chaos.folder());
  }
  for (std::size_t k = 0; k < ratios.size(); ++k) {
    std::string all;
    for (const double ratio : ratios.at(k)) all += std::to_string(ratio) + " ";
    ::testing::Test::RecordProperty(kErrorKeys.at(k), all);
    const auto middle = ratios.at(k).begin() + 2;
    std::nth_element(ratios.at(k).begin(), middle, ratios.at(k).end());
    EXPECT_LE(*middle, factor) << kErrorKeys.at(k) << ": " << all;
  }
  return runs;
}

}  // namespace imslam::testing

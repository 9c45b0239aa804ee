#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/trajectory_file.hpp"
#include "slam/base/error.hpp"
#include "slam/evaluation/align.hpp"
#include "slam/evaluation/associate.hpp"
#include "slam/evaluation/errors.hpp"
#include "slam/evaluation/kitti.hpp"
#include "slam/evaluation/names.hpp"
#include "slam/evaluation/rigid_matrix.hpp"
#include "slam/evaluation/statistics.hpp"
#include "tests/support/test_data.hpp"

// Every case that evo 1.36 was run on: the same figures, the same pair counts, the same refusals.

namespace imslam::evaluation {
namespace {

using nlohmann::json;

constexpr double kTolerance = 1e-9;
// Errors that are zero but for rounding (the first pose after alignment by origin: 1e-15) have no
// relative error; everything above is held to kTolerance of itself.
constexpr double kNoise = 1e-12;

std::filesystem::path folder() { return testing::test_fixtures() / "evo"; }

class EvoGolden : public ::testing::Test {
 protected:
  void SetUp() override {
    IMSLAM_NEEDS(folder() / "expected.json");
    std::ifstream(folder() / "expected.json") >> expected_;
  }

  const MatchedPaths& matched(const std::string& set) {
    auto& slot = matched_[set];
    if (slot.estimate.size() == 0) {
      const std::string ending = set.front() == 'k' ? ".kitti" : ".tum";
      slot = associate(datasets::read_trajectory(folder() / (set + "_ref" + ending)),
                       datasets::read_trajectory(folder() / (set + "_est" + ending)));
    }
    return slot;
  }

  static AlignmentOptions alignment_of(const json& wanted) {
    AlignmentOptions options;
    const auto name = wanted.at("align").get<std::string>();
    if (name == "se3_n100") {
      options.first = 100;
      options.kind = Alignment::kSe3;
    } else {
      options.kind = alignment_names().at(name);
    }
    return options;
  }

  static DeltaOptions delta_of(const json& wanted) {
    DeltaOptions options;
    options.delta = wanted.at("delta").get<double>();
    options.unit = delta_unit_names().at(wanted.at("unit").get<std::string>());
    options.all_pairs = wanted.at("all_pairs").get<bool>();
    options.pairs_from_reference = wanted.at("pairs_from_reference").get<bool>();
    return options;
  }

  void compare(double actual, double expected, const std::string& what) {
    if (std::abs(expected) < kNoise) {
      EXPECT_NEAR(actual, expected, kNoise) << what;
      return;
    }
    const double relative = std::abs(actual - expected) / std::abs(expected);
    worst_ = std::max(worst_, relative);
    EXPECT_LE(relative, kTolerance) << what << ": " << actual << " instead of " << expected;
  }

  void compare_stats(const ErrorSeries& series, const json& wanted) {
    ASSERT_EQ(series.errors.size(), wanted.at("n").get<std::size_t>()) << wanted;
    const Statistics s = statistics(series.errors);
    const std::map<std::string, double> actual = {
        {"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.std},
        {"min", s.min},   {"max", s.max},   {"sse", s.sse}};
    ASSERT_EQ(actual.size(), wanted.at("stats").size());
    for (const auto& [name, value] : wanted.at("stats").items()) {
      compare(actual.at(name), value.get<double>(), name + " of " + wanted.dump());
    }
  }

  void compare_transform(const Similarity& found, const json& wanted) {
    const json& rows = wanted.at("sim3");
    if (rows.empty()) return;
    const Eigen::Matrix4d T = found.matrix();
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) {
        EXPECT_NEAR(T(r, c), rows.at(static_cast<std::size_t>(r)).at(static_cast<std::size_t>(c)),
                    1e-9 * T.cwiseAbs().maxCoeff())
            << wanted;
      }
    }
  }

  void run_case(const json& wanted) {
    const MatchedPaths& m = matched(wanted.at("set"));
    const AlignedPath aligned = align(m.reference, m.estimate, alignment_of(wanted));
    const Relation relation = relation_names().at(wanted.at("relation").get<std::string>());
    if (wanted.at("metric") == "ape") {
      compare_stats(absolute_errors(m.reference, aligned.estimate, relation), wanted);
      compare_transform(aligned.transform, wanted);
    } else {
      compare_stats(relative_errors(m.reference, aligned.estimate, relation, delta_of(wanted)),
                    wanted);
    }
  }

  json expected_;
  std::map<std::string, MatchedPaths> matched_;
  double worst_ = 0.0;
};

TEST_F(EvoGolden, EveryStatisticAgrees) {
  int cases = 0;
  for (const json& wanted : expected_.at("results")) {
    if (wanted.at("metric") == "kitti_odometry" || wanted.contains("error")) continue;
    run_case(wanted);
    ++cases;
    if (HasFatalFailure()) return;
  }
  EXPECT_GE(cases, 500);
  std::cout << cases << " cases, worst relative difference " << worst_ << "\n";
  RecordProperty("cases", cases);
}

TEST_F(EvoGolden, EveryRefusalHasTheSameReason) {
  int cases = 0;
  for (const json& wanted : expected_.at("results")) {
    if (!wanted.contains("error")) continue;
    try {
      run_case(wanted);
      ADD_FAILURE() << "accepted: " << wanted;
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(), wanted.at("error").get<std::string>());
      EXPECT_EQ(error.code(), ExitCode::kEvaluation);
    }
    ++cases;
  }
  EXPECT_GE(cases, 100);
  std::cout << cases << " refusals\n";
}

TEST_F(EvoGolden, KittiDevkitFiguresAgree) {
  int cases = 0;
  for (const json& wanted : expected_.at("results")) {
    if (wanted.at("metric") != "kitti_odometry") continue;
    const MatchedPaths& m = matched(wanted.at("set"));
    const Drift drift = kitti_drift(m.reference, m.estimate);
    EXPECT_EQ(drift.segments.size(), wanted.at("n").get<std::size_t>());
    compare(drift.t_rel_percent, wanted.at("t_rel_percent"), "t_rel");
    compare(drift.r_rel_deg_per_100m, wanted.at("r_rel_deg_per_100m"), "r_rel");
    compare(drift.r_rel_deg_per_100m / 100.0, wanted.at("r_rel_deg_per_m"), "r_rel per m");
    ASSERT_EQ(drift.by_length.size(), wanted.at("by_length").size());
    for (const DriftBin& bin : drift.by_length) {
      const json& row = wanted.at("by_length").at(std::to_string(static_cast<int>(bin.key)));
      EXPECT_EQ(bin.count, row.at("n").get<std::size_t>());
      compare(bin.t_percent, row.at("t_percent"), "t by length");
      compare(bin.r_deg_per_100m, row.at("r_deg_per_100m"), "r by length");
    }
    ++cases;
  }
  EXPECT_EQ(cases, 2);
  std::cout << cases << " KITTI cases, worst relative difference " << worst_ << "\n";
}

}  // namespace
}  // namespace imslam::evaluation

// A damaged IMU through the executable; the figures of ../shared/reference/reliability.md, M5-M9.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/chaos.hpp"
#include "tests/support/pooled_check.hpp"
#include "tests/support/run_check.hpp"
#include "tests/support/tum_file.hpp"

namespace imslam {
namespace {

using testing::Chaos;
using testing::clean_run;
using testing::expect_error_within;
using testing::run_checked;
using testing::TempDir;

class DamagedImu : public ::testing::Test {
 protected:
  testing::CheckedRun run(int expected_code = 0) {
    return run_checked(dir_, chaos_.folder(), "", "run", expected_code);
  }
  testing::CommandResult run_only() {
    return testing::run_imslam(dir_, "run " + testing::quoted(chaos_.folder().string()) +
                                         " --out " +
                                         testing::quoted((dir_.path() / "run").string()));
  }

  TempDir dir_;
  Chaos chaos_{testing::simulated_base().sequence, dir_.path() / "spoiled"};
};

struct BadSamples {
  const char* name;
  const char* value;
  double length_s;
  double factor;  ///< of the clean run's error that may be reached
};
void PrintTo(const BadSamples& samples, std::ostream* stream) { *stream << samples.name; }

class DamagedSamples : public DamagedImu, public ::testing::WithParamInterface<BadSamples> {};

TEST_P(DamagedSamples, CostNoMoreThanTheyMust) {  // M7
  chaos_.edit_imu({3.0, 3.0 + GetParam().length_s}, [](Chaos::Reading& reading) {
    for (const std::size_t axis : {1U, 3U}) reading.at(axis) = GetParam().value;
  });
  expect_error_within(GetParam().factor, run());
}

INSTANTIATE_TEST_SUITE_P(Values,
                         DamagedSamples,
                         ::testing::Values(BadSamples{"ANan", "nan", 0.004, 1.1},
                                           BadSamples{"TenMsOfNan", "nan", 0.01, 1.1},
                                           BadSamples{"HundredMsOfNan", "nan", 0.1, 1.5},
                                           BadSamples{"TenMsOfInfinity", "-inf", 0.01, 1.1},
                                           BadSamples{"TenMsOf1e30", "1e30", 0.01, 1.1},
                                           BadSamples{"HundredMsOf1e30", "1e30", 0.1, 1.5},
                                           BadSamples{"TenMsSaturated", "200", 0.01, 1.1},
                                           BadSamples{"HundredMsSaturated", "200", 0.1, 1.5}),
                         [](const auto& each) { return std::string(each.param.name); });

class ImuGap : public DamagedImu, public ::testing::WithParamInterface<int> {
 protected:
  /// Error of the motion per frame [m], rms over frames within [from_s, to_s) of a trajectory that
  /// was estimated online, where nothing is smoothed from later.
  static double step_error_m(const std::filesystem::path& run, double from_s, double to_s) {
    const auto truth = testing::read_tum(run / "truth.tum");
    const auto online = testing::read_tum(run / "online.tum");
    const double start_s = online.front().time_s;
    const auto at = [&](double time_s) {
      return std::min_element(truth.begin(), truth.end(),
                              [&](const auto& a, const auto& b) {
                                return std::abs(a.time_s - time_s) < std::abs(b.time_s - time_s);
                              })
          ->T;
    };
    double square = 0.0;
    int count = 0;
    for (std::size_t i = 1; i < online.size(); ++i) {
      const double s = online[i].time_s - start_s;
      if (s < from_s || s >= to_s) continue;
      const lie::SE3d seen = online[i - 1].T.inverse() * online[i].T;
      const lie::SE3d true_step = at(online[i - 1].time_s).inverse() * at(online[i].time_s);
      square += (true_step.inverse() * seen).translation().squaredNorm();
      ++count;
    }
    EXPECT_GT(count, 0);
    return std::sqrt(square / count);
  }

  static void expect_flagged(const testing::CheckedRun& spoiled, double length_s) {
    EXPECT_EQ(spoiled.counter("imu_gaps") > 0, length_s >= 0.05);
    int frames = 0;
    for (const auto& segment : spoiled.metrics.at("segments")) {
      if (segment.at("kind") != "imu_gap") continue;
      frames += segment.at("frames").get<int>();
      EXPECT_GE(segment.at("from_s").get<double>(), 2.0);
      EXPECT_LE(segment.at("to_s").get<double>(), 2.0 + length_s + 0.05 + 1e-6);  // one frame
    }
    EXPECT_EQ(frames, spoiled.counter("imu_gaps"));
  }
};

TEST_P(ImuGap, IsSurvivedFlaggedAndForgottenWithinTwoSeconds) {  // M8
  const double length_s = 1e-3 * GetParam();
  const auto runs = testing::expect_pooled_error_within(1.5, dir_, [&](Chaos& chaos) {
    chaos.cut_lines(chaos.imu_csv(), {2.0, 2.0 + length_s});
  });
  for (const auto& spoiled : runs) expect_flagged(spoiled, length_s);
  const double from_s = 2.0 + length_s + 2.0;
  std::vector<double> steps;
  std::vector<double> clean_steps;
  const testing::SimulatedBase base = testing::simulated_base();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    clean_steps.push_back(step_error_m(base.recordings[i].clean_run, from_s, 1e9));
    steps.push_back(step_error_m(dir_.path() / ("run" + std::to_string(i + 1)), from_s, 1e9));
  }
  constexpr double kLuck_m = 1e-3;  // steps of a few frames: below it a ratio says nothing
  EXPECT_LE(testing::root_mean_square(steps),
            std::max(1.5 * testing::root_mean_square(clean_steps), kLuck_m));
}

INSTANTIATE_TEST_SUITE_P(Milliseconds,
                         ImuGap,
                         ::testing::Values(20, 50, 100, 500, 1000),
                         [](const auto& each) { return "Gap" + std::to_string(each.param); });

TEST_F(DamagedImu, SwappedLinesChangeNothing) {  // M5
  chaos_.swap_neighbours(chaos_.imu_csv(), 50);
  EXPECT_EQ(run().trajectory, clean_run().trajectory);
}

TEST_F(DamagedImu, RepeatedLinesChangeNothing) {  // M6
  chaos_.repeat_lines(chaos_.imu_csv(), 0.1);
  EXPECT_EQ(run().trajectory, clean_run().trajectory);
}

TEST_F(DamagedImu, AClockSetBackByAnHourIsADataErrorWithItsLine) {  // M5, M9
  chaos_.move_stamps(chaos_.imu_csv(), 3.0, -3'600'000'000'000);
  const auto result = run_only();
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.err.find("data.csv:602"), std::string::npos) << result.err;
}

TEST_F(DamagedImu, AClockThatLeapsAnHourAheadEndsInVision) {  // M9
  chaos_.move_stamps(chaos_.imu_csv(), 3.0, 3'600'000'000'000);
  expect_error_within(3.0, run());  // what vision alone reaches from there on
}

TEST_F(DamagedImu, AnotherUnitOfTimeIsADataError) {  // M9
  chaos_.move_stamps(chaos_.imu_csv(), -1e9, 0, 1e-3);
  EXPECT_EQ(run_only().exit_code, 3);
}

TEST_F(DamagedImu, AShiftedClockIsMeasured) {  // M9
  chaos_.move_stamps(chaos_.imu_csv(), -1e9, 20'000'000);
  const auto spoiled = run();
  const auto offset_s = [](const testing::CheckedRun& r) {
    return r.metrics.at("calibration").at("time_offset_s").get<double>();
  };
  EXPECT_NEAR(std::abs(offset_s(spoiled) - offset_s(clean_run())), 0.02, 0.003);
  expect_error_within(2.0, spoiled);
}

}  // namespace
}  // namespace imslam

// Damaged images through the executable; the figures of ../shared/reference/reliability.md, M1-M14.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "tests/support/chaos.hpp"
#include "tests/support/pooled_check.hpp"

namespace imslam {
namespace {

using testing::Chaos;
using testing::clean_run;
using testing::expect_error_within;
using testing::expect_pooled_error_within;
using testing::run_checked;
using testing::TempDir;
using Side = Chaos::Side;

class DamagedImages : public ::testing::Test {
 protected:
  testing::CheckedRun run() { return run_checked(dir_, chaos_.folder()); }

  TempDir dir_;
  Chaos chaos_{testing::simulated_base().sequence, dir_.path() / "spoiled"};
};

struct Missing {
  const char* name;
  Side side;
  double share;
  double factor;     ///< of the unspoiled error that may be reached
  int at_least = 0;  ///< so many frames are lost in each recording of 121
};
void PrintTo(const Missing& missing, std::ostream* stream) { *stream << missing.name; }

class MissingImages : public ::testing::TestWithParam<Missing> {};

TEST_P(MissingImages, CostNoMoreThanTheyMust) {  // M4
  const Missing& missing = GetParam();
  const TempDir dir;
  const auto runs = expect_pooled_error_within(
      missing.factor, dir, [&](Chaos& chaos) { chaos.drop_images(missing.side, missing.share); });
  for (const auto& run : runs) EXPECT_GE(run.counter("frames_missing"), missing.at_least);
}

INSTANTIATE_TEST_SUITE_P(Images,
                         MissingImages,
                         ::testing::Values(Missing{"AFewPairs", Side::kBoth, 0.05, 1.2, 1},
                                           Missing{"EveryFifthPair", Side::kBoth, 0.2, 2.0, 12},
                                           Missing{"EveryFifthLeft", Side::kLeft, 0.2, 2.0, 6},
                                           Missing{"EveryFifthRight", Side::kRight, 0.2, 2.0, 6}),
                         [](const auto& each) { return std::string(each.param.name); });

TEST_F(DamagedImages, TheImuBridgesASecondWithoutImages) {  // M4
  chaos_.drop_images(Side::kBoth, {3.0, 4.0});
  const auto spoiled = run();
  // Drift of 2 % of the distance covered.
  EXPECT_LE(spoiled.metrics.at("graph").at("end_error_percent").get<double>(), 2.0);
  EXPECT_LE(spoiled.ate_m(), 0.02 * clean_run().metrics.at("path_length_m").get<double>());
}

TEST(TruncatedImages, CountAsMissing) {  // M1
  const TempDir dir;
  const auto runs = expect_pooled_error_within(
      1.2, dir, [](Chaos& chaos) { chaos.truncate_images(Side::kBoth, 0.05); });
  for (const auto& run : runs) EXPECT_GT(run.counter("frames_missing"), 0);
}

TEST(OtherThingsNamedPng, CountAsMissing) {  // M1
  const TempDir dir;
  const auto runs = expect_pooled_error_within(1.2, dir, [](Chaos& chaos) {
    chaos.replace_images(Side::kLeft, 0.03, "");
    chaos.replace_images(Side::kRight, 0.03, "this is not an image\n");
  });
  for (const auto& run : runs) EXPECT_GT(run.counter("frames_missing"), 0);
}

TEST_F(DamagedImages, FlippedBitsNeverSpoilTheTrajectory) {  // M1
  chaos_.flip_bits(Side::kBoth, 0.2, 20);
  expect_error_within(2.0, run());
}

TEST_F(DamagedImages, SixteenBitAndColourImagesAreUsedAsTheyAre) {  // M1
  chaos_.paint(Side::kLeft, Chaos::everything(),
               [](cv::Mat& image, Random&) { image.convertTo(image, CV_16U, 257.0); });
  chaos_.paint(Side::kRight, Chaos::everything(), [](cv::Mat& image, Random&) {
    const std::vector<cv::Mat> channels(3, image.clone());
    cv::merge(channels, image);
  });
  EXPECT_EQ(run().trajectory, clean_run().trajectory);
}

TEST_F(DamagedImages, ImagesOfAnotherSizeCountAsMissing) {  // M1
  int number = 0;
  chaos_.paint(Side::kLeft, {2.0, 5.0}, [&](cv::Mat& image, Random&) {
    if (++number % 20 == 0) image = image(cv::Rect(0, 0, image.cols - 1, image.rows)).clone();
  });
  const auto spoiled = run();
  EXPECT_EQ(spoiled.counter("frames_missing"), 3);
  expect_error_within(1.2, spoiled);
}

struct Blindness {
  const char* name;
  Chaos::Pixels pixels;
};
void PrintTo(const Blindness& blindness, std::ostream* stream) { *stream << blindness.name; }

class Blinded : public DamagedImages, public ::testing::WithParamInterface<Blindness> {};

TEST_P(Blinded, TwoSecondsAreBridgedAndSaidToBeDegraded) {  // M12
  chaos_.paint(Side::kBoth, {2.5, 4.5}, GetParam().pixels);
  const auto spoiled = run();
  EXPECT_GT(spoiled.counter("frames_degraded") + spoiled.counter("vo_failures"), 30);
  EXPECT_LE(spoiled.ate_m(), 0.02 * clean_run().metrics.at("path_length_m").get<double>());
}

INSTANTIATE_TEST_SUITE_P(
    Images,
    Blinded,
    ::testing::Values(Blindness{"Black", [](cv::Mat& image, Random&) { image.setTo(0); }},
                      Blindness{"White", [](cv::Mat& image, Random&) { image.setTo(255); }},
                      Blindness{"Noise",
                                [](cv::Mat& image, Random& random) {
                                  for (auto p = image.begin<std::uint8_t>();
                                       p != image.end<std::uint8_t>(); ++p)
                                    *p = static_cast<std::uint8_t>(random.integer(0, 255));
                                }}),
    [](const auto& each) { return std::string(each.param.name); });

TEST_F(DamagedImages, SwappedLinesOfTheIndexChangeNothing) {  // M5
  chaos_.swap_neighbours(chaos_.left_csv(), 12);
  chaos_.swap_neighbours(chaos_.right_csv(), 12);
  EXPECT_EQ(run().trajectory, clean_run().trajectory);
}

TEST_F(DamagedImages, RepeatedLinesOfTheIndexChangeNothing) {  // M6
  chaos_.repeat_lines(chaos_.left_csv(), 0.1);
  chaos_.repeat_lines(chaos_.right_csv(), 0.1);
  EXPECT_EQ(run().trajectory, clean_run().trajectory);
}

}  // namespace
}  // namespace imslam

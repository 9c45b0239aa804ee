#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <ostream>
#include <vector>

#include "tests/support/chaos.hpp"

namespace imslam::testing {

/// A way in which a whole recording's images get worse, at severities 1 to 5.
struct Degradation {
  const char* name;
  std::array<double, 5> values;  ///< what the severities mean
  std::function<void(cv::Mat&, int frame, double value, Random&)> apply;

  void spoil(Chaos& chaos, int severity) const {
    const double value = values.at(static_cast<std::size_t>(severity - 1));
    chaos.paint_frames(
        Chaos::Side::kBoth, Chaos::everything(),
        [&](cv::Mat& image, int frame, Random& random) { apply(image, frame, value, random); });
  }
};

inline void PrintTo(const Degradation& degradation, std::ostream* stream) {
  *stream << degradation.name;
}

/// Every second second of a recording at 20 Hz: what comes and goes.
inline bool in_odd_second(int frame) { return frame / 20 % 2 == 1; }

inline void apply_gain(cv::Mat& image, double gain) { image.convertTo(image, -1, gain); }

inline void apply_gamma(cv::Mat& image, double gamma) {
  cv::Mat table(1, 256, CV_8U);
  for (int i = 0; i < 256; ++i) {
    table.at<std::uint8_t>(i) = cv::saturate_cast<std::uint8_t>(255.0 * std::pow(i / 255.0, gamma));
  }
  cv::LUT(image, table, image);
}

inline void apply_noise(cv::Mat& image, double sigma, Random& random) {
  for (auto p = image.begin<std::uint8_t>(); p != image.end<std::uint8_t>(); ++p) {
    *p = cv::saturate_cast<std::uint8_t>(*p + sigma * random.normal());
  }
}

/// Blots of a twelfth of the image's width, black or white, new ones in every image.
inline void apply_blots(cv::Mat& image, double share, Random& random) {
  const int side = image.cols / 12;
  cv::Mat covered = cv::Mat::zeros(image.size(), CV_8U);
  while (cv::countNonZero(covered) < share * static_cast<double>(image.total())) {
    const auto x = static_cast<int>(random.integer(-side / 2, image.cols - side / 2));
    const auto y = static_cast<int>(random.integer(-side / 2, image.rows - side / 2));
    const cv::Rect blot = cv::Rect(x, y, side, side) & cv::Rect(0, 0, image.cols, image.rows);
    image(blot).setTo(random.chance(0.5) ? 0 : 255);
    covered(blot).setTo(1);
  }
}

/// The rows of M13.
inline std::vector<Degradation> degradations() {
  const auto step = [](cv::Mat& image, int frame, double gain, Random&) {
    if (in_odd_second(frame)) apply_gain(image, gain);
  };
  return {
      {"Brighter", {1.5, 2.0, 2.5, 3.0, 4.0}, step},
      {"Darker", {0.7, 0.5, 0.4, 0.33, 0.25}, step},
      {"Flicker",
       {0.05, 0.1, 0.2, 0.3, 0.5},
       [](cv::Mat& image, int frame, double share, Random&) {
         apply_gain(image, 1.0 + share * std::sin(2.4 * frame));
       }},
      {"Gamma",
       {1.25, 1.5, 2.0, 2.5, 3.0},
       [](cv::Mat& image, int frame, double gamma, Random&) {
         apply_gamma(image, in_odd_second(frame) ? gamma : 1.0 / gamma);
       }},
      {"Blur",
       {1.0, 2.0, 3.0, 4.0, 5.0},
       [](cv::Mat& image, int, double sigma, Random&) {
         cv::GaussianBlur(image, image, cv::Size(), sigma);
       }},
      {"Noise",
       {5.0, 10.0, 15.0, 20.0, 30.0},
       [](cv::Mat& image, int, double sigma, Random& random) {
         apply_noise(image, sigma, random);
       }},
      {"Blots",
       {0.1, 0.2, 0.3, 0.4, 0.5},
       [](cv::Mat& image, int, double share, Random& random) {
         apply_blots(image, share, random);
       }},
      {"DirtyLens",
       {0.1, 0.2, 0.3, 0.4, 0.5},
       [](cv::Mat& image, int, double share, Random&) {
         Random same(7);  // the dirt stays where it is
         apply_blots(image, share, same);
       }},
  };
}

}  // namespace imslam::testing

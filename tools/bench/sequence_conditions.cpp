#include "tools/bench/sequence_conditions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/support/chaos.hpp"
#include "tests/support/degradation.hpp"

namespace imslam::bench {
namespace {

using testing::Chaos;

constexpr std::uint64_t kSeed = 11;
constexpr double kPi = 3.14159265358979323846;

/// Which image of the recording is spoiled.
struct View {
  int frame = 0;
  bool right = false;
};

/// What both images of a pair have in common is drawn from this.
Random of_pair(const View& view) {
  return Random(kSeed).fork(static_cast<std::uint64_t>(view.frame));
}

void motion_blur(cv::Mat& image, const View& view, double length) {
  const double angle = kPi * of_pair(view).uniform();
  const int side = 2 * static_cast<int>(std::ceil(length / 2.0)) + 1;
  cv::Mat kernel = cv::Mat::zeros(side, side, CV_32F);
  const int steps = 8 * side;
  for (int i = 0; i <= steps; ++i) {  // bilinear splats along the smear
    const double along = length * (static_cast<double>(i) / steps - 0.5);
    const double x = side / 2 + along * std::cos(angle);
    const double y = side / 2 + along * std::sin(angle);
    const int x0 = static_cast<int>(std::floor(x));
    const int y0 = static_cast<int>(std::floor(y));
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        if (x0 + dx < 0 || x0 + dx >= side || y0 + dy < 0 || y0 + dy >= side) continue;
        kernel.at<float>(y0 + dy, x0 + dx) +=
            static_cast<float>((1.0 - std::abs(x - x0 - dx)) * (1.0 - std::abs(y - y0 - dy)));
      }
    }
  }
  cv::filter2D(image, image, -1, kernel / cv::sum(kernel)[0], cv::Point(-1, -1), 0.0,
               cv::BORDER_REPLICATE);
}

void add_noise(cv::Mat& image, const View& view, double read, double shot) {
  Random random = of_pair(view).fork(view.right ? 1 : 0);
  for (auto p = image.begin<std::uint8_t>(); p != image.end<std::uint8_t>(); ++p) {
    const double sigma = std::sqrt(read * read + shot * static_cast<double>(*p));
    *p = cv::saturate_cast<std::uint8_t>(static_cast<double>(*p) + sigma * random.normal());
  }
}

void darken(cv::Mat& image, const View& view, double share) {
  testing::apply_gain(image, share);
  add_noise(image, view, 2.0, 0.02);
}

void step_exposure(cv::Mat& image, const View& view, double gain) {
  if (testing::in_odd_second(view.frame)) testing::apply_gain(image, gain);
}

void noise(cv::Mat& image, const View& view, double sigma) { add_noise(image, view, sigma, 0.0); }

/// Where something is that goes to and fro between 0 and `range`.
double bounce(double start, double speed, int frame, double range) {
  const double there = std::fmod(std::abs(start + speed * frame), 2.0 * range);
  return there < range ? there : 2.0 * range - there;
}

void moving(cv::Mat& image, const View& view, double count) {
  const int side = image.cols / 8;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    Random random = Random(kSeed).fork(static_cast<std::uint64_t>(i));
    // A piece of noise, smooth enough to be followed; the same in all images.
    cv::Mat piece(side / 4 + 1, side / 4 + 1, CV_8U);
    const double level = random.uniform(60.0, 180.0);
    for (auto p = piece.begin<std::uint8_t>(); p != piece.end<std::uint8_t>(); ++p) {
      *p = cv::saturate_cast<std::uint8_t>(level + 45.0 * random.normal());
    }
    cv::resize(piece, piece, cv::Size(side, side), 0, 0, cv::INTER_CUBIC);
    const double angle = 2.0 * kPi * random.uniform();
    const double speed = random.uniform(2.0, 12.0);
    const double disparity = random.uniform(0.06, 0.1) * image.cols;
    const double x = bounce(random.uniform(0.0, image.cols), speed * std::cos(angle), view.frame,
                            image.cols - side) -
                     (view.right ? disparity : 0.0);
    const double y = bounce(random.uniform(0.0, image.rows), speed * std::sin(angle), view.frame,
                            image.rows - side);
    const cv::Matx23d shift(1.0, 0.0, x, 0.0, 1.0, y);
    cv::warpAffine(piece, image, shift, image.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
  }
}

struct Recipe {
  const char* name;
  std::array<double, 5> values;
  void (*apply)(cv::Mat& image, const View& view, double value);
};

const std::array<Recipe, 6>& recipes() {
  static const std::array<Recipe, 6> kRecipes{{
      {"motion_blur", {4.0, 8.0, 12.0, 16.0, 21.0}, motion_blur},
      {"dark", {0.4, 0.25, 0.15, 0.08, 0.04}, darken},
      {"brighter", {1.25, 1.6, 2.0, 2.5, 4.0}, step_exposure},
      {"darker", {0.8, 0.6, 0.4, 0.25, 0.15}, step_exposure},
      {"noise", {5.0, 10.0, 15.0, 20.0, 30.0}, noise},
      {"moving", {3.0, 6.0, 12.0, 20.0, 30.0}, moving},
  }};
  return kRecipes;
}

}  // namespace

void SequenceCondition::spoil(const std::filesystem::path& base,
                              const std::filesystem::path& folder,
                              int severity) const {
  const auto recipe = std::find_if(recipes().begin(), recipes().end(),
                                   [&](const Recipe& each) { return name == each.name; });
  const double value = recipe->values.at(static_cast<std::size_t>(severity - 1));
  Chaos chaos(base, folder);
  for (const bool right : {false, true}) {
    chaos.paint_frames(right ? Chaos::Side::kRight : Chaos::Side::kLeft, Chaos::everything(),
                       [&](cv::Mat& image, int frame, Random&) {
                         recipe->apply(image, {frame, right}, value);
                       });
  }
}

std::vector<SequenceCondition> sequence_conditions() {
  std::vector<SequenceCondition> conditions;
  for (const Recipe& recipe : recipes()) conditions.push_back({recipe.name});
  return conditions;
}

}  // namespace imslam::bench

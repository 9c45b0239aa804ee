#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "tools/bench/matching/method.hpp"

namespace imslam::bench {
namespace {

using Points = std::vector<Eigen::Vector2d>;
using vo::MatchKind;

cv::Mat view(const GrayImage& image) {
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data())};
}

/// Bilinear, the border repeated outwards.
Eigen::Vector2d flow_at(const cv::Mat& flow, const Eigen::Vector2d& p) {
  const double u = std::clamp(p.x(), 0.0, flow.cols - 1.001);
  const double v = std::clamp(p.y(), 0.0, flow.rows - 1.001);
  const int column = static_cast<int>(u);
  const int row = static_cast<int>(v);
  const auto at = [&](int r, int c) {
    const auto& value = flow.at<cv::Vec2f>(r, c);
    return Eigen::Vector2d(double{value[0]}, double{value[1]});
  };
  const double fx = u - column;
  const double fy = v - row;
  return (1 - fy) * ((1 - fx) * at(row, column) + fx * at(row, column + 1)) +
         fy * ((1 - fx) * at(row + 1, column) + fx * at(row + 1, column + 1));
}

class DisMethod final : public Method {
 public:
  std::vector<std::string> names(MatchKind) const override { return {kName}; }

  std::vector<Answer> match(MatchKind kind,
                            const GrayImage& image0,
                            const GrayImage& image1,
                            const Points& points) const override {
    const cv::Mat forth = flow(image0, image1);
    const cv::Mat back = flow(image1, image0);
    Answer answer{kName, {}};
    for (const Eigen::Vector2d& point : points) {
      PointMatch match;
      match.answered = match.accepted = true;
      match.displacement = flow_at(forth, point);
      Eigen::Vector2d round_trip = match.displacement + flow_at(back, point + match.displacement);
      if (kind == MatchKind::kStereo) round_trip.y() = 0.0;
      match.score = -round_trip.norm();
      answer.matches.push_back(match);
    }
    return {answer};
  }

 private:
  static constexpr const char* kName = "DIS";

  static cv::Mat flow(const GrayImage& from, const GrayImage& to) {
    cv::Mat result;
    cv::DISOpticalFlow::create(cv::DISOpticalFlow::PRESET_MEDIUM)
        ->calc(view(from), view(to), result);
    return result;
  }
};

class SgbmMethod final : public Method {
 public:
  std::vector<std::string> names(MatchKind kind) const override {
    return kind == MatchKind::kStereo ? std::vector<std::string>{kName}
                                      : std::vector<std::string>{};
  }

  std::vector<Answer> match(MatchKind,
                            const GrayImage& image0,
                            const GrayImage& image1,
                            const Points& points) const override {
    const cv::Mat left = disparity(view(image0), view(image1));
    // The right view's disparity: what is right becomes left in the mirror.
    cv::Mat mirrored0;
    cv::Mat mirrored1;
    cv::flip(view(image0), mirrored0, 1);
    cv::flip(view(image1), mirrored1, 1);
    cv::Mat right;
    cv::flip(disparity(mirrored1, mirrored0), right, 1);
    Answer answer{kName, {}};
    for (const Eigen::Vector2d& point : points) {
      answer.matches.push_back(match_at(left, right, static_cast<int>(std::lround(point.y())),
                                        static_cast<int>(std::lround(point.x()))));
    }
    return {answer};
  }

 private:
  static constexpr const char* kName = "SGBM";
  static constexpr int kDisparities = 192;
  static constexpr int kBlock = 5;
  static constexpr double kSteps = 16.0;  // per pixel

  /// 16 bit, in sixteenths of a pixel, negative where there is none.
  static cv::Mat disparity(const cv::Mat& left, const cv::Mat& right) {
    // Columns to the left of the image, so that disparities up to its border are searched.
    cv::Mat wide_left;
    cv::Mat wide_right;
    cv::copyMakeBorder(left, wide_left, 0, 0, kDisparities, 0, cv::BORDER_CONSTANT, 0);
    cv::copyMakeBorder(right, wide_right, 0, 0, kDisparities, 0, cv::BORDER_CONSTANT, 0);
    cv::Mat wide;
    cv::StereoSGBM::create(0, kDisparities, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock, 1,
                           31, 10, 100, 2, cv::StereoSGBM::MODE_SGBM_3WAY)
        ->compute(wide_left, wide_right, wide);
    return wide.colRange(kDisparities, wide.cols).clone();
  }

  static PointMatch match_at(const cv::Mat& left, const cv::Mat& right, int row, int column) {
    PointMatch match;
    const double d = left.at<std::int16_t>(row, column) / kSteps;
    if (d < 0.0) return match;
    match.answered = match.accepted = true;
    match.displacement = {-d, 0.0};
    const int landing = std::clamp(column - static_cast<int>(std::lround(d)), 0, right.cols - 1);
    const double back = right.at<std::int16_t>(row, landing) / kSteps;
    match.score = back < 0.0 ? -static_cast<double>(kDisparities) : -std::abs(d - back);
    return match;
  }
};

}  // namespace

std::unique_ptr<Method> make_dis() { return std::make_unique<DisMethod>(); }
std::unique_ptr<Method> make_sgbm() { return std::make_unique<SgbmMethod>(); }

}  // namespace imslam::bench

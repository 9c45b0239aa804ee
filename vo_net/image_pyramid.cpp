#include "vo_net/image_pyramid.hpp"

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slam/base/error.hpp"

namespace imslam::vo {
namespace {

constexpr int kMinSide = 16;  // [px] smaller levels say nothing

cv::Mat padded_view(std::vector<float>& buffer, int width, int height) {
  const int stride = width + 2 * ImagePyramid::kBorder;
  buffer.resize(static_cast<std::size_t>(stride) *
                static_cast<std::size_t>(height + 2 * ImagePyramid::kBorder));
  return {height + 2 * ImagePyramid::kBorder, stride, CV_32F, buffer.data()};
}

cv::Mat interior(const cv::Mat& padded) {
  const int b = ImagePyramid::kBorder;
  return padded(cv::Rect(b, b, padded.cols - 2 * b, padded.rows - 2 * b));
}

/// Fills the border of `padded` from its interior.
void mirror_border(cv::Mat& padded) {
  const int b = ImagePyramid::kBorder;
  cv::copyMakeBorder(interior(padded), padded, b, b, b, b,
                     cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
}

}  // namespace

ImagePyramid& ImagePyramid::operator=(const ImagePyramid& other) {
  if (this == &other) return *this;
  buffers_ = other.buffers_;
  levels_ = other.levels_;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    levels_[l].pixels = buffers_[l].data() + (other.levels_[l].pixels - other.buffers_[l].data());
  }
  return *this;
}

void ImagePyramid::build(const GrayImage& image, int levels, double smoothing) {
  expects(!image.empty() && levels >= 1, "ImagePyramid::build: needs an image and a level");
  levels_.clear();
  buffers_.resize(static_cast<std::size_t>(levels));

  // OpenCV has no view of constant pixels; they are only read.
  const cv::Mat source(image.height, image.width, CV_8U,
                       const_cast<std::uint8_t*>(image.pixels.data()));
  int width = image.width;
  int height = image.height;
  cv::Mat finer;
  for (std::size_t l = 0; l < buffers_.size(); ++l) {
    if (l > 0 && (width < kMinSide || height < kMinSide)) break;
    cv::Mat padded = padded_view(buffers_[l], width, height);
    cv::Mat inner = interior(padded);
    if (l == 0) {
      source.convertTo(inner, CV_32F);
      if (smoothing > 0.0) {
        const int size = 2 * static_cast<int>(std::ceil(2.5 * smoothing)) + 1;
        cv::GaussianBlur(inner, inner, cv::Size(size, size), smoothing, smoothing,
                         cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
      }
    } else {
      cv::pyrDown(finer, inner, inner.size(), cv::BORDER_REFLECT_101);
    }
    mirror_border(padded);
    const int stride = padded.cols;
    levels_.push_back({width, height, stride, buffers_[l].data() + kBorder * stride + kBorder});
    finer = inner;
    width = (width + 1) / 2;
    height = (height + 1) / 2;
  }
}

}  // namespace imslam::vo

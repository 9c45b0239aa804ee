#include "slam/base/error.hpp"
#include "slam/nn/kernels/convolution.hpp"

namespace imslam::nn {
namespace {

int output_length(int length, int kernel, int stride, int padding, int dilation) {
  return (length + 2 * padding - dilation * (kernel - 1) - 1) / stride + 1;
}

bool fits(int length, int kernel, int padding, int dilation) {
  return length + 2 * padding >= dilation * (kernel - 1) + 1;
}

std::size_t product(int a, int b, int c, int d) {
  return static_cast<std::size_t>(a) * static_cast<std::size_t>(b) * static_cast<std::size_t>(c) *
         static_cast<std::size_t>(d);
}

std::string list(std::initializer_list<int> sizes) {
  std::string text;
  for (const int size : sizes) text += (text.empty() ? "[" : ", ") + std::to_string(size);
  return text + "]";
}

}  // namespace

int ConvolutionShape::out_height() const {
  return output_length(in_height, kernel_height, stride_y, padding_y, dilation_y);
}

int ConvolutionShape::out_width() const {
  return output_length(in_width, kernel_width, stride_x, padding_x, dilation_x);
}

std::size_t ConvolutionShape::input_size() const {
  return product(batch, in_height, in_width, in_channels);
}

std::size_t ConvolutionShape::weight_size() const {
  return product(kernel_height, kernel_width, in_channels, out_channels);
}

std::size_t ConvolutionShape::output_size() const {
  return product(batch, out_height(), out_width(), out_channels);
}

void ConvolutionShape::validate() const {
  const bool positive = batch > 0 && in_height > 0 && in_width > 0 && in_channels > 0 &&
                        out_channels > 0 && kernel_height > 0 && kernel_width > 0 && stride_y > 0 &&
                        stride_x > 0 && dilation_y > 0 && dilation_x > 0;
  // The text only for a failure: validate() runs in every call, which must not allocate.
  const auto require = [this](bool condition, const char* what) {
    if (!condition) throw ContractError("convolution of " + text() + ": " + what);
  };
  require(positive, "all sizes, strides and dilations must be positive");
  require(padding_y >= 0 && padding_x >= 0, "padding must not be negative");
  require(fits(in_height, kernel_height, padding_y, dilation_y) &&
              fits(in_width, kernel_width, padding_x, dilation_x),
          "the kernel is larger than the padded input");
}

std::string ConvolutionShape::text() const {
  return "x " + list({batch, in_height, in_width, in_channels}) + ", w " +
         list({kernel_height, kernel_width, in_channels, out_channels}) + ", stride " +
         list({stride_y, stride_x}) + ", padding " + list({padding_y, padding_x}) + ", dilation " +
         list({dilation_y, dilation_x});
}

}  // namespace imslam::nn

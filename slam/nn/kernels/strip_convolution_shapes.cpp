#include <utility>

#include "slam/nn/kernels/strip_convolution.hpp"

namespace imslam::nn::kernels {
namespace {

ConvolutionAxis backward(const ConvolutionAxis& forward) {
  ConvolutionAxis axis = forward;
  std::swap(axis.in, axis.out);
  std::swap(axis.stride, axis.step);
  axis.backward = true;
  return axis;
}

}  // namespace

bool StripConvolution::is_narrow(const KernelTable& table) const {
  return 2 * out_channels <= table.lanes && 2 * in_channels >= kBlock;
}

ChannelGroups StripConvolution::groups(const KernelTable& table) const {
  if (is_narrow(table)) return {out_channels, 1, kNarrowOutputs};
  return {out_channels, table.lanes, table.most_packets};
}

int StripConvolution::weight_channels(const KernelTable& table) const {
  return is_narrow(table) ? (in_channels + kBlock - 1) / kBlock * kBlock : in_channels;
}

StripConvolution StripConvolution::forward(const ConvolutionShape& shape) {
  StripConvolution c;
  c.vertical = {shape.in_height,     shape.out_height(), shape.stride_y,   1,
                shape.kernel_height, shape.padding_y,    shape.dilation_y, false};
  c.horizontal = {shape.in_width,     shape.out_width(), shape.stride_x,   1,
                  shape.kernel_width, shape.padding_x,   shape.dilation_x, false};
  c.batch = shape.batch;
  c.in_channels = shape.in_channels;
  c.out_channels = shape.out_channels;
  return c;
}

StripConvolution StripConvolution::backward_data(const ConvolutionShape& shape) {
  StripConvolution c = forward(shape);
  c.vertical = backward(c.vertical);
  c.horizontal = backward(c.horizontal);
  std::swap(c.in_channels, c.out_channels);
  return c;
}

}  // namespace imslam::nn::kernels

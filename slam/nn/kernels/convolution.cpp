#include "slam/nn/kernels/convolution.hpp"

#include "slam/base/error.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "slam/nn/kernels/strip_convolution.hpp"

namespace imslam::nn {
namespace {

using kernels::StripConvolution;

/// Values below zero are multiplied with this.
float negative_slope(Activation activation) {
  switch (activation) {
    case Activation::kRelu:
      return 0.0F;
    case Activation::kLeakyRelu:
      return kLeakySlope;
    default:
      return 1.0F;
  }
}

kernels::WeightLayout forward_layout(const ConvolutionShape& shape, const float* w) {
  const std::ptrdiff_t outputs = shape.out_channels;
  return {w, shape.in_channels * outputs, outputs, 1};
}

}  // namespace

PackedWeights::PackedWeights(const ConvolutionShape& shape, const float* w, const float* b) {
  shape.validate();
  const StripConvolution convolution = StripConvolution::forward(shape);
  const kernels::KernelTable& table = kernels::selected_kernels();
  data_.resize(kernels::packed_weight_size(convolution, table));
  kernels::pack_weights(convolution, forward_layout(shape, w), b, table, data_.data());
}

void convolution_forward(const ConvolutionShape& shape,
                         const float* x,
                         const float* w,
                         const float* b,
                         Activation activation,
                         float* y,
                         Workspace* workspace) {
  shape.validate();
  Workspace own;
  if (workspace == nullptr) workspace = &own;
  const StripConvolution convolution = StripConvolution::forward(shape);
  const kernels::KernelTable& table = kernels::selected_kernels();
  float* packed = workspace->buffer(0, kernels::packed_weight_size(convolution, table));
  kernels::pack_weights(convolution, forward_layout(shape, w), b, table, packed);
  kernels::convolve_strips(convolution, x, packed, negative_slope(activation), table, y,
                           *workspace);
}

void convolution_forward(const ConvolutionShape& shape,
                         const float* x,
                         const PackedWeights& weights,
                         Activation activation,
                         float* y,
                         Workspace* workspace) {
  shape.validate();
  const StripConvolution convolution = StripConvolution::forward(shape);
  const kernels::KernelTable& table = kernels::selected_kernels();
  expects(weights.data_.size() == kernels::packed_weight_size(convolution, table),
          ("convolution_forward: weights were packed for another shape or instruction set than " +
           shape.text())
              .c_str());
  Workspace own;
  kernels::convolve_strips(convolution, x, weights.data_.data(), negative_slope(activation), table,
                           y, workspace == nullptr ? own : *workspace);
}

void convolution_backward_data(const ConvolutionShape& shape,
                               const float* w,
                               const float* dy,
                               float* dx,
                               Workspace* workspace) {
  shape.validate();
  Workspace own;
  if (workspace == nullptr) workspace = &own;
  const StripConvolution convolution = StripConvolution::backward_data(shape);
  const kernels::KernelTable& table = kernels::selected_kernels();
  float* packed = workspace->buffer(0, kernels::packed_weight_size(convolution, table));
  const std::ptrdiff_t outputs = shape.out_channels;
  const kernels::WeightLayout layout = {w, shape.in_channels * outputs, 1, outputs};
  kernels::pack_weights(convolution, layout, nullptr, table, packed);
  kernels::convolve_strips(convolution, dy, packed, 1.0F, table, dx, *workspace);
}

}  // namespace imslam::nn

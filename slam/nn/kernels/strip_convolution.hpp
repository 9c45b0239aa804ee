#pragma once

#include <cstddef>

#include "slam/nn/kernels/channel_groups.hpp"
#include "slam/nn/kernels/convolution.hpp"
#include "slam/nn/kernels/convolution_axis.hpp"
#include "slam/nn/kernels/kernel_table.hpp"

namespace imslam::nn::kernels {

/// Forward convolution, or backward data written as a convolution of dy: strips of the input are
/// packed once and multiplied with all packed weights.
struct StripConvolution {
  ConvolutionAxis vertical, horizontal;
  int batch = 1;
  int in_channels = 1;   ///< of what is read
  int out_channels = 1;  ///< of what is written

  /// So few outputs that packets run along the input channels.
  bool is_narrow(const KernelTable& table) const;
  ChannelGroups groups(const KernelTable& table) const;
  /// Input channels that a group's weights have, with zeros up to whole blocks where it is narrow.
  int weight_channels(const KernelTable& table) const;

  static StripConvolution forward(const ConvolutionShape& shape);
  /// Reads dy, writes dx.
  static StripConvolution backward_data(const ConvolutionShape& shape);
};

/// Where w(tap, in, out) lies; the two directions differ in which channel is contiguous.
struct WeightLayout {
  const float* w;
  std::ptrdiff_t tap_pitch, in_pitch, out_pitch;
};

/// Floats of packed weights with their bias.
std::size_t packed_weight_size(const StripConvolution& convolution, const KernelTable& table);

/// [bias], then for each phase, group of output channels, block, tap, channel: one value for each
/// output channel of the group; zeros behind the last channel. Narrow: the output before the
/// channel. bias may be null.
void pack_weights(const StripConvolution& convolution,
                  const WeightLayout& weights,
                  const float* bias,
                  const KernelTable& table,
                  float* packed);

void convolve_strips(const StripConvolution& convolution,
                     const float* x,
                     const float* packed_weights,
                     float negative_slope,
                     const KernelTable& table,
                     float* y,
                     Workspace& workspace);

}  // namespace imslam::nn::kernels

#include <algorithm>

#include "slam/nn/kernels/channel_groups.hpp"
#include "slam/nn/kernels/strip_convolution.hpp"

namespace imslam::nn::kernels {
namespace {

/// One tap, up to kBlock input channels, one group of output channels.
float* pack_tap(
    const WeightLayout& weights, const float* from, int channels, int used, int width, float* to) {
  for (int c = 0; c < channels; ++c, from += weights.in_pitch, to += width) {
    if (weights.out_pitch == 1) {
      std::copy_n(from, used, to);
    } else {
      for (int o = 0; o < used; ++o) to[o] = from[o * weights.out_pitch];
    }
    std::fill(to + used, to + width, 0.0F);
  }
  return to;
}

/// Likewise with the outputs apart, each with all channels of the block.
float* pack_narrow_tap(
    const WeightLayout& weights, const float* from, int channels, int outputs, float* to) {
  for (int o = 0; o < outputs; ++o, from += weights.out_pitch, to += kBlock) {
    for (int c = 0; c < kBlock; ++c) to[c] = c < channels ? from[c * weights.in_pitch] : 0.0F;
  }
  return to;
}

float* pack_phase(const StripConvolution& convolution,
                  const WeightLayout& weights,
                  const ChannelGroups& groups,
                  bool narrow,
                  const AxisTaps& rows,
                  const AxisTaps& columns,
                  float* to) {
  for (int g = 0; g < groups.count(); ++g) {
    const ChannelGroup group = groups.group(g);
    const int width = group.packets * groups.lanes();
    const int used = width - groups.lanes() + group.last_lanes;
    for (int c = 0; c < convolution.in_channels; c += kBlock) {
      const int channels = std::min(kBlock, convolution.in_channels - c);
      for (int k = 0; k < rows.count; ++k) {
        for (int l = 0; l < columns.count; ++l) {
          const int tap = (rows.first_tap + k * rows.tap_step) * convolution.horizontal.kernel +
                          columns.first_tap + l * columns.tap_step;
          const float* from = weights.w + tap * weights.tap_pitch + c * weights.in_pitch +
                              group.first_channel * weights.out_pitch;
          to = narrow ? pack_narrow_tap(weights, from, channels, width, to)
                      : pack_tap(weights, from, channels, used, width, to);
        }
      }
    }
  }
  return to;
}

}  // namespace

std::size_t packed_weight_size(const StripConvolution& convolution, const KernelTable& table) {
  const ChannelGroups groups = convolution.groups(table);
  const auto taps = static_cast<std::size_t>(convolution.vertical.kernel) *
                    static_cast<std::size_t>(convolution.horizontal.kernel);
  return static_cast<std::size_t>(groups.padded()) *
         (taps * static_cast<std::size_t>(convolution.weight_channels(table)) + 1);
}

void pack_weights(const StripConvolution& convolution,
                  const WeightLayout& weights,
                  const float* bias,
                  const KernelTable& table,
                  float* packed) {
  const ChannelGroups groups = convolution.groups(table);
  std::fill_n(packed, groups.padded(), 0.0F);
  if (bias != nullptr) std::copy_n(bias, convolution.out_channels, packed);
  packed += groups.padded();
  for (int i = 0; i < convolution.vertical.step; ++i) {
    for (int j = 0; j < convolution.horizontal.step; ++j) {
      packed = pack_phase(convolution, weights, groups, convolution.is_narrow(table),
                          convolution.vertical.taps(i), convolution.horizontal.taps(j), packed);
    }
  }
}

}  // namespace imslam::nn::kernels

#pragma once

#include <type_traits>

#include "slam/nn/kernels/convolution.hpp"
#include "slam/nn/shape.hpp"

namespace imslam::nn {

// The convolutions of kernels/convolution.hpp for scalars other than float, as six plain loops: the
// definition that the fast kernels are tested against. Overload resolution picks the fast ones for
// float.

/// visit(at_x, at_w, at_y): offsets of the channels of each pair of input and output pixels that
/// meet.
template <typename Visit>
void for_each_tap(const ConvolutionShape& s, const Visit& visit) {
  const Index taps_x = s.kernel_width;
  for (Index n = 0; n < s.batch; ++n) {
    for (Index i = 0; i < s.out_height(); ++i) {
      for (Index j = 0; j < s.out_width(); ++j) {
        const Index at_y = ((n * s.out_height() + i) * s.out_width() + j) * s.out_channels;
        for (Index k = 0; k < s.kernel_height; ++k) {
          const Index row = i * s.stride_y + k * s.dilation_y - s.padding_y;
          if (row < 0 || row >= s.in_height) continue;
          for (Index l = 0; l < taps_x; ++l) {
            const Index column = j * s.stride_x + l * s.dilation_x - s.padding_x;
            if (column < 0 || column >= s.in_width) continue;
            visit(((n * s.in_height + row) * s.in_width + column) * s.in_channels,
                  (k * taps_x + l) * s.in_channels * s.out_channels, at_y);
          }
        }
      }
    }
  }
}

template <typename S>
void convolution_forward(const ConvolutionShape& s,
                         const S* x,
                         const S* w,
                         const S* b,
                         Activation activation,
                         S* y,
                         Workspace*) {
  s.validate();
  const Index channels = s.out_channels;
  const Index size = static_cast<Index>(s.output_size());
  for (Index i = 0; i < size; ++i) y[i] = b == nullptr ? S(0) : b[i % channels];
  for_each_tap(s, [&](Index at_x, Index at_w, Index at_y) {
    for (Index c = 0; c < s.in_channels; ++c) {
      for (Index d = 0; d < channels; ++d) {
        y[at_y + d] += x[at_x + c] * w[at_w + c * channels + d];
      }
    }
  });
  const double below = activation == Activation::kNone        ? 1.0
                       : activation == Activation::kLeakyRelu ? double(kLeakySlope)
                                                              : 0.0;
  for (Index i = 0; i < size; ++i) {
    if (y[i] < S(0)) y[i] = S(below) * y[i];
  }
}

template <typename S>
void convolution_backward_data(
    const ConvolutionShape& s, const S* w, const S* dy, S* dx, Workspace*) {
  s.validate();
  const Index size = static_cast<Index>(s.input_size());
  for (Index i = 0; i < size; ++i) dx[i] = S(0);
  for_each_tap(s, [&](Index at_x, Index at_w, Index at_y) {
    for (Index c = 0; c < s.in_channels; ++c) {
      for (Index d = 0; d < s.out_channels; ++d) {
        dx[at_x + c] += dy[at_y + d] * w[at_w + c * s.out_channels + d];
      }
    }
  });
}

template <typename S>
void convolution_backward_weights(
    const ConvolutionShape& s, const S* x, const S* dy, S* dw, S* db, Workspace*) {
  s.validate();
  const Index weights = static_cast<Index>(s.weight_size());
  const Index size = static_cast<Index>(s.output_size());
  for (Index i = 0; i < weights; ++i) dw[i] = S(0);
  for_each_tap(s, [&](Index at_x, Index at_w, Index at_y) {
    for (Index c = 0; c < s.in_channels; ++c) {
      for (Index d = 0; d < s.out_channels; ++d) {
        dw[at_w + c * s.out_channels + d] += x[at_x + c] * dy[at_y + d];
      }
    }
  });
  if (db == nullptr) return;
  for (Index d = 0; d < s.out_channels; ++d) db[d] = S(0);
  for (Index i = 0; i < size; ++i) db[i % s.out_channels] += dy[i];
}

}  // namespace imslam::nn

#pragma once

#include <vector>

#include "slam/nn/kernels/convolution.hpp"

namespace imslam::nn::testing {

using Array = std::vector<float>;

/// Calls body(index of y, index of x, index of w) for every product of the convolution.
template <typename Body>
void for_each_product(const ConvolutionShape& s, const Body& body) {
  for (int n = 0; n < s.batch; ++n) {
    for (int i = 0; i < s.out_height(); ++i) {
      for (int j = 0; j < s.out_width(); ++j) {
        for (int k = 0; k < s.kernel_height; ++k) {
          for (int l = 0; l < s.kernel_width; ++l) {
            const int y = i * s.stride_y + k * s.dilation_y - s.padding_y;
            const int x = j * s.stride_x + l * s.dilation_x - s.padding_x;
            if (y < 0 || y >= s.in_height || x < 0 || x >= s.in_width) continue;
            const int out = ((n * s.out_height() + i) * s.out_width() + j) * s.out_channels;
            const int in = ((n * s.in_height + y) * s.in_width + x) * s.in_channels;
            const int tap = (k * s.kernel_width + l) * s.in_channels;
            for (int c = 0; c < s.in_channels; ++c) {
              for (int o = 0; o < s.out_channels; ++o) {
                body(static_cast<std::size_t>(out + o), static_cast<std::size_t>(in + c),
                     static_cast<std::size_t>((tap + c) * s.out_channels + o));
              }
            }
          }
        }
      }
    }
  }
}

inline Array rounded(const std::vector<double>& sums) { return Array(sums.begin(), sums.end()); }

inline Array reference_forward(const ConvolutionShape& s,
                               const Array& x,
                               const Array& w,
                               const Array& b,
                               Activation activation) {
  std::vector<double> y(s.output_size());
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = b.empty() ? 0.0 : double(b[i % b.size()]);
  for_each_product(s, [&](std::size_t out, std::size_t in, std::size_t weight) {
    y[out] += double(x[in]) * double(w[weight]);
  });
  Array result = rounded(y);
  for (float& value : result) {
    if (value >= 0 || activation == Activation::kNone) continue;
    value = activation == Activation::kRelu ? 0.0F : kLeakySlope * value;
  }
  return result;
}

inline Array reference_backward_data(const ConvolutionShape& s, const Array& w, const Array& dy) {
  std::vector<double> dx(s.input_size());
  for_each_product(s, [&](std::size_t out, std::size_t in, std::size_t weight) {
    dx[in] += double(dy[out]) * double(w[weight]);
  });
  return rounded(dx);
}

inline Array reference_backward_weights(const ConvolutionShape& s,
                                        const Array& x,
                                        const Array& dy) {
  std::vector<double> dw(s.weight_size());
  for_each_product(s, [&](std::size_t out, std::size_t in, std::size_t weight) {
    dw[weight] += double(x[in]) * double(dy[out]);
  });
  return rounded(dw);
}

inline Array reference_backward_bias(const ConvolutionShape& s, const Array& dy) {
  std::vector<double> db(static_cast<std::size_t>(s.out_channels));
  for (std::size_t i = 0; i < dy.size(); ++i) db[i % db.size()] += double(dy[i]);
  return rounded(db);
}

}  // namespace imslam::nn::testing

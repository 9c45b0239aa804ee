#include "slam/nn/kernels/convolution.hpp"

#include <algorithm>

namespace imslam::nn {
namespace {

/// Calls body(output pixel, input pixel, tap) for every pair that the kernel connects.
template <typename Body>
void for_each_tap(const ConvolutionShape& s, const Body& body) {
  const auto at = [](int a, int size, int b) { return a * size + b; };
  for (int n = 0; n < s.batch; ++n) {
    for (int i = 0; i < s.out_height(); ++i) {
      for (int j = 0; j < s.out_width(); ++j) {
        for (int k = 0; k < s.kernel_height; ++k) {
          for (int l = 0; l < s.kernel_width; ++l) {
            const int y = i * s.stride_y + k * s.dilation_y - s.padding_y;
            const int x = j * s.stride_x + l * s.dilation_x - s.padding_x;
            if (y < 0 || y >= s.in_height || x < 0 || x >= s.in_width) continue;
            body(at(at(n, s.out_height(), i), s.out_width(), j),
                 at(at(n, s.in_height, y), s.in_width, x), at(k, s.kernel_width, l));
          }
        }
      }
    }
  }
}

float activate(float value, Activation activation) {
  if (activation == Activation::kNone || value > 0) return value;
  return activation == Activation::kRelu ? 0.0F : kLeakySlope * value;
}

}  // namespace

PackedWeights::PackedWeights(const ConvolutionShape& shape, const float* w, const float* b) {
  data_.assign(w, w + shape.weight_size());
  const auto outputs = static_cast<std::size_t>(shape.out_channels);
  if (b == nullptr) data_.insert(data_.end(), outputs, 0.0F);
  if (b != nullptr) data_.insert(data_.end(), b, b + outputs);
}

void convolution_forward(const ConvolutionShape& shape,
                         const float* x,
                         const float* w,
                         const float* b,
                         Activation activation,
                         float* y,
                         Workspace* /*workspace*/) {
  shape.validate();
  const int inputs = shape.in_channels;
  const int outputs = shape.out_channels;
  const auto size = static_cast<std::ptrdiff_t>(shape.output_size());
  for (std::ptrdiff_t i = 0; i < size; ++i) y[i] = b == nullptr ? 0.0F : b[i % outputs];
  for_each_tap(shape, [&](std::ptrdiff_t out, std::ptrdiff_t in, std::ptrdiff_t tap) {
    for (int c = 0; c < inputs; ++c) {
      for (int o = 0; o < outputs; ++o) {
        y[out * outputs + o] += x[in * inputs + c] * w[(tap * inputs + c) * outputs + o];
      }
    }
  });
  for (std::ptrdiff_t i = 0; i < size; ++i) y[i] = activate(y[i], activation);
}

void convolution_forward(const ConvolutionShape& shape,
                         const float* x,
                         const PackedWeights& weights,
                         Activation activation,
                         float* y,
                         Workspace* workspace) {
  const float* w = weights.data_.data();
  convolution_forward(shape, x, w, w + shape.weight_size(), activation, y, workspace);
}

void convolution_backward_data(const ConvolutionShape& shape,
                               const float* w,
                               const float* dy,
                               float* dx,
                               Workspace* /*workspace*/) {
  shape.validate();
  const int inputs = shape.in_channels;
  const int outputs = shape.out_channels;
  std::fill_n(dx, shape.input_size(), 0.0F);
  for_each_tap(shape, [&](std::ptrdiff_t out, std::ptrdiff_t in, std::ptrdiff_t tap) {
    for (int c = 0; c < inputs; ++c) {
      for (int o = 0; o < outputs; ++o) {
        dx[in * inputs + c] += dy[out * outputs + o] * w[(tap * inputs + c) * outputs + o];
      }
    }
  });
}

void convolution_backward_weights(const ConvolutionShape& shape,
                                  const float* x,
                                  const float* dy,
                                  float* dw,
                                  float* db,
                                  Workspace* /*workspace*/) {
  shape.validate();
  const int inputs = shape.in_channels;
  const int outputs = shape.out_channels;
  std::fill_n(dw, shape.weight_size(), 0.0F);
  for_each_tap(shape, [&](std::ptrdiff_t out, std::ptrdiff_t in, std::ptrdiff_t tap) {
    for (int c = 0; c < inputs; ++c) {
      for (int o = 0; o < outputs; ++o) {
        dw[(tap * inputs + c) * outputs + o] += x[in * inputs + c] * dy[out * outputs + o];
      }
    }
  });
  if (db == nullptr) return;
  std::fill_n(db, outputs, 0.0F);
  const auto size = static_cast<std::ptrdiff_t>(shape.output_size());
  for (std::ptrdiff_t i = 0; i < size; ++i) db[i % outputs] += dy[i];
}

}  // namespace imslam::nn

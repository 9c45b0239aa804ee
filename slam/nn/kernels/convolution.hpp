#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "slam/nn/kernels/workspace.hpp"

namespace imslam::nn {

/// Sizes of one convolution; a 1-D convolution has height 1, a matrix product kernel 1 x 1.
///
///   y[n, i, j, :] = b + sum over (k, l) of x[n, i stride_y + k dilation_y - padding_y,
///                                            j stride_x + l dilation_x - padding_x, :] w[k, l]
///
/// with zeros outside of x. All arrays are row-major with the channels last and contiguous:
/// x [N, H, W, Cin], w [Ky, Kx, Cin, Cout], b [Cout], y [N, Ho, Wo, Cout].
struct ConvolutionShape {
  int batch = 1;
  int in_height = 1;
  int in_width = 1;
  int in_channels = 1;
  int out_channels = 1;
  int kernel_height = 1;
  int kernel_width = 1;
  int stride_y = 1;
  int stride_x = 1;
  int padding_y = 0;
  int padding_x = 0;
  int dilation_y = 1;
  int dilation_x = 1;

  int out_height() const;
  int out_width() const;

  std::size_t input_size() const;   ///< floats of x
  std::size_t weight_size() const;  ///< floats of w
  std::size_t output_size() const;  ///< floats of y

  /// Throws ContractError if a size is not positive, a padding negative or the output empty.
  void validate() const;
  std::string text() const;  ///< "x [1, 192, 640, 16], w [3, 3, 16, 32], stride ..."
};

/// Applied to the sum, fused with its storing. Leaky: x > 0 ? x : 0.1 x.
enum class Activation { kNone, kRelu, kLeakyRelu };
inline constexpr float kLeakySlope = 0.1F;

/// Weights and bias in the order in which the forward kernel reads them: packed once for many
/// calls. Belongs to the instruction set that was selected when it was made.
class PackedWeights {
 public:
  PackedWeights() = default;
  PackedWeights(const ConvolutionShape& shape, const float* w, const float* b);

  bool empty() const { return data_.empty(); }

 private:
  friend void convolution_forward(const ConvolutionShape& shape,
                                  const float* x,
                                  const PackedWeights& weights,
                                  Activation activation,
                                  float* y,
                                  Workspace* workspace);
  std::vector<float> data_;
};

/// y is overwritten; b may be null. Equal bytes for any number of threads; the bytes depend on the
/// instruction set. Without a workspace the call allocates its own scratch.
void convolution_forward(const ConvolutionShape& shape,
                         const float* x,
                         const float* w,
                         const float* b,
                         Activation activation,
                         float* y,
                         Workspace* workspace = nullptr);

/// The same with packed weights; allocates nothing once the workspace has its size.
void convolution_forward(const ConvolutionShape& shape,
                         const float* x,
                         const PackedWeights& weights,
                         Activation activation,
                         float* y,
                         Workspace* workspace = nullptr);

/// dx [N, H, W, Cin] = dL/dx from dy = dL/dy (of the sum, before any activation); overwritten.
void convolution_backward_data(const ConvolutionShape& shape,
                               const float* w,
                               const float* dy,
                               float* dx,
                               Workspace* workspace = nullptr);

/// dw [Ky, Kx, Cin, Cout] = dL/dw and db [Cout] = dL/db; overwritten; db may be null.
void convolution_backward_weights(const ConvolutionShape& shape,
                                  const float* x,
                                  const float* dy,
                                  float* dw,
                                  float* db,
                                  Workspace* workspace = nullptr);

}  // namespace imslam::nn

#pragma once

#include <cstddef>

/// What the translation units of one instruction set show to the rest: plain structs and a table of
/// functions. No inline function may stand here: the linker would keep one copy of it, perhaps
/// that of a unit whose instructions the machine lacks.
namespace imslam::nn::kernels {

/// Channels of one block of a packed strip. All instruction sets share it.
constexpr int kBlock = 16;
/// A part of an image and where it goes: channels in blocks, the columns sorted by their remainder
/// modulo the stride, zeros where the part leaves the image.
///
///   packed[b block_pitch + r row_pitch + ((u % stride) lane_columns + u / stride) pixel_pitch + c]
///     = image[first_row + r, first_column + u, 16 b + c]
struct StripCopy {
  const float* image;  ///< [height, width, channels]
  int height, width, channels;
  int first_row, first_column;
  int rows, columns;
  int stride;
  int lane_columns;
  int pixel_pitch;
  std::ptrdiff_t row_pitch, block_pitch;
  float* packed;
};

/// One row of output pixels times one group of output channels.
///
///   output[p, :] = activation(bias + sum over (b, tap, c) of
///                             input[b block_pitch + taps[tap] + p pixel_pitch + c] weights[b, tap,
///                             c, :])
struct RowProduct {
  const float* input;
  const float* next;  ///< input of the next row: a hint
  int pixel_pitch;
  int blocks, last_channels;  ///< all blocks but the last have kBlock channels; few: see taps
  std::ptrdiff_t block_pitch;
  const std::ptrdiff_t* taps;  ///< where pixel_pitch < kBlock: of each channel
  int tap_count;
  const float* weights;  ///< [blocks, taps, channels, packets * lanes]
  const float* bias;     ///< [packets * lanes]
  float* output;
  std::ptrdiff_t output_pitch;
  int pixels;
  int packets, last_lanes;  ///< of the last packet only so many lanes are stored
  float negative_slope;     ///< 1: no activation, 0: ReLU
};

/// sum[r, :] += over rows and pixels of x[r] dy[:], for up to kBlock channels of one tap or, where
/// pixel_pitch < kBlock, for all (tap, channel), which then lie at `taps`.
struct OuterProduct {
  const float* x;  ///< packed strip, at the tap
  const std::ptrdiff_t* taps;
  const float* dy;  ///< [rows, pixels, packets * lanes]
  std::ptrdiff_t x_row_pitch;
  int pixel_pitch;
  int rows, pixels;
  int channels;  ///< or (tap, channel)
  int packets;
  float* sum;                    ///< [channels, packets * lanes]
  const float *hint, *hint_end;  ///< memory to prefetch meanwhile
};

/// packed[p, :] = dy[p pixel_pitch, :], one group of output channels; sum[:] += over pixels of dy.
struct GradientCopy {
  const float* dy;
  std::ptrdiff_t pixel_pitch;
  int pixels;
  int packets, last_lanes;
  float* packed;
  float* sum;  ///< [packets * lanes]
};

/// One row of pixels of twice the size: y[j] = fine[j] + coarse row at j / 2, between its pixels.
struct UpsampleRow {
  const float *above, *below;  ///< [ceil(width / 2), channels]; the same row if it lies on one
  const float* fine;           ///< [width, channels]
  float* y;                    ///< [width, channels]
  int width, channels;
};

/// y = x w for a few rows, as in a recurrent step: w is read as it is, once for each four rows.
struct ThinProduct {
  const float* x;  ///< [rows, inner]
  const float* w;  ///< [inner, columns]
  float* y;        ///< [rows, columns]
  int rows, inner, columns;
};

/// Most outputs of a group of a narrow product.
constexpr int kNarrowOutputs = 4;

struct KernelTable {
  int lanes;         ///< floats of a packet
  int most_packets;  ///< of a group of output channels
  void (*copy_strip)(const StripCopy&);
  void (*row_product)(const RowProduct&);
  void (*narrow_product)(const RowProduct&);
  void (*copy_gradient)(const GradientCopy&);
  void (*outer_product)(const OuterProduct&);
  void (*upsample_add)(const UpsampleRow&);
  /// y = max(a + b, 0)
  void (*add_relu)(const float* a, const float* b, std::ptrdiff_t count, float* y);
  /// y[i] = <query, pixels[i, :]>
  void (*dot_products)(
      const float* query, const float* pixels, std::ptrdiff_t count, int channels, float* y);
  /// y[r, :] = inverse[r] x[r, :], inverse[r] = 1 / sqrt(|x[r, :]|^2 + smallest_square)
  void (*unit_rows)(const float* x,
                    std::ptrdiff_t rows,
                    int channels,
                    float smallest_square,
                    float* inverse,
                    float* y);
  void (*thin_product)(const ThinProduct&);
};

const KernelTable* sse2_kernels();
const KernelTable* avx2_kernels();
const KernelTable* avx512_kernels();

}  // namespace imslam::nn::kernels

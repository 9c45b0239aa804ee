#pragma once

#include <cstddef>

#include "slam/nn/kernels/convolution_axis.hpp"
#include "slam/nn/kernels/kernel_table.hpp"

namespace imslam::nn::kernels {

/// A rectangle of cells of one image of the batch.
struct Strip {
  int image = 0;
  int first_row = 0;
  int first_column = 0;
  int rows = 0;
  int columns = 0;
};

/// Cuts the cells of a convolution into strips whose packed input stays in the caches. The cut
/// depends on the sizes alone, never on the number of threads.
class StripGrid {
 public:
  /// Strips of at most `most_columns` columns and about `cells` cells.
  StripGrid(const ConvolutionAxis& vertical,
            const ConvolutionAxis& horizontal,
            int batch,
            int channels,
            int most_columns,
            int cells);

  int count() const { return batch_ * row_strips_ * column_strips_; }
  Strip strip(int index) const;

  int pixel_pitch() const { return pixel_pitch_; }
  int blocks() const { return blocks_; }
  int last_channels() const { return channels_ - (blocks_ - 1) * kBlock; }
  /// Few channels are so many taps of one channel each: the kernel's loop over them would be short.
  int channels_as_taps() const { return pixel_pitch_ < kBlock ? channels_ : 1; }
  int strip_rows() const { return strip_rows_; }
  int strip_columns() const { return strip_columns_; }
  std::ptrdiff_t row_pitch() const { return row_pitch_; }
  std::ptrdiff_t block_pitch() const { return block_pitch_; }
  /// Floats of a packed strip.
  std::size_t packed_size() const;

  /// Where, in the packed strip, the tap at these offsets finds the input of the first cell.
  std::ptrdiff_t tap_position(int row_offset, int column_offset) const;

  /// How to pack the input of a strip of `x` [batch, height, width, channels].
  StripCopy copy(const Strip& strip, const float* x, float* packed) const;

 private:
  void fit(int most_columns, int cells);

  ConvolutionAxis vertical_, horizontal_;
  int batch_, channels_, blocks_, pixel_pitch_;
  int row_base_, column_base_;  // lowest offsets of taps
  int row_span_, column_span_;  // input rows and columns that one cell reads
  int strip_rows_ = 1, strip_columns_ = 1, row_strips_ = 1, column_strips_ = 1;
  int packed_rows_ = 1, packed_columns_ = 1, lane_columns_ = 1;
  std::ptrdiff_t row_pitch_ = 0, block_pitch_ = 0;
};

}  // namespace imslam::nn::kernels

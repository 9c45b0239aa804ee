#pragma once

#include <cstddef>

#include "slam/nn/kernels/axis_cuts.hpp"
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
  bool inside = false;  ///< all that its taps read lies inside of the image
};

/// How large strips may be.
struct StripLimits {
  int columns;       ///< of a strip
  int cells;         ///< of a strip, about
  int edge_columns;  ///< 0, or the width of strips set apart at the image's edges, so that the
                     ///< others are inside
};

/// Cuts the cells of a convolution into strips whose packed input stays in the caches. The cut
/// depends on the sizes alone, never on the number of threads.
class StripGrid {
 public:
  StripGrid(const ConvolutionAxis& vertical,
            const ConvolutionAxis& horizontal,
            int batch,
            int channels,
            StripLimits limits);

  int count() const { return batch_ * rows_.count() * columns_.count(); }
  Strip strip(int index) const;
  int longest_row() const { return columns_.longest(); }
  int most_rows() const { return rows_.longest(); }

  int pixel_pitch() const { return pixel_pitch_; }
  int blocks() const { return blocks_; }
  int last_channels() const { return channels_ - (blocks_ - 1) * kBlock; }
  std::ptrdiff_t row_pitch() const { return row_pitch_; }
  std::ptrdiff_t block_pitch() const { return block_pitch_; }
  /// Floats of a packed strip.
  std::size_t packed_size() const;
  /// Few channels are so many taps of one channel each: the kernel's loop over them would be short.
  int channels_as_taps() const { return pixel_pitch_ < kBlock ? channels_ : 1; }

  /// Where, in the packed strip, the tap at these offsets finds the input of the first cell.
  std::ptrdiff_t tap_position(int row_offset, int column_offset) const;

  /// How to pack the input of a strip of `x` [batch, height, width, channels].
  StripCopy copy(const Strip& strip, const float* x, float* packed) const;

 private:
  void fit(const StripLimits& limits);

  ConvolutionAxis vertical_, horizontal_;
  int batch_, channels_, blocks_, pixel_pitch_;
  int row_base_, column_base_;  // lowest offsets of taps
  int row_span_, column_span_;  // input rows and columns that one cell reads
  AxisCuts rows_, columns_;
  int lane_columns_ = 1;
  std::ptrdiff_t row_pitch_ = 0, block_pitch_ = 0;
};

}  // namespace imslam::nn::kernels

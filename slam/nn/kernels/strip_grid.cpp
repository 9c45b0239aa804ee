#include "slam/nn/kernels/strip_grid.hpp"

#include <algorithm>

namespace imslam::nn::kernels {
namespace {

constexpr std::ptrdiff_t kMostFloats = 64 * 1024;  // half of a 512 kB second-level cache
constexpr int kFewColumns = 28;                    // of a strip; fewer do not fill a tile

int divide_up(int a, int b) { return (a + b - 1) / b; }

/// Pixels of few channels lie close together, the others in blocks.
int pitch_of(int channels) {
  if (channels == 1) return 1;
  return channels <= 4 ? 4 : kBlock;
}

}  // namespace

StripGrid::StripGrid(const ConvolutionAxis& vertical,
                     const ConvolutionAxis& horizontal,
                     int batch,
                     int channels,
                     int most_columns,
                     int cells)
    : vertical_(vertical),
      horizontal_(horizontal),
      batch_(batch),
      channels_(channels),
      blocks_(divide_up(channels, kBlock)),
      pixel_pitch_(pitch_of(channels)),
      row_base_(vertical.lowest_offset()),
      column_base_(horizontal.lowest_offset()),
      row_span_(vertical.highest_offset() - row_base_ + 1),
      column_span_(horizontal.highest_offset() - column_base_ + 1) {
  fit(most_columns, cells);
  while (block_pitch_ * blocks_ > kMostFloats && strip_rows_ > 1) fit(most_columns, cells /= 2);
  while (block_pitch_ * blocks_ > kMostFloats && strip_columns_ > kFewColumns) {
    fit(most_columns /= 2, 1);
  }
}

void StripGrid::fit(int most_columns, int cells) {
  column_strips_ = divide_up(horizontal_.cells(0), std::max(1, most_columns));
  strip_columns_ = divide_up(horizontal_.cells(0), column_strips_);
  row_strips_ = divide_up(vertical_.cells(0), std::max(1, cells / strip_columns_));
  strip_rows_ = divide_up(vertical_.cells(0), row_strips_);
  column_strips_ = divide_up(horizontal_.cells(0), strip_columns_);
  row_strips_ = divide_up(vertical_.cells(0), strip_rows_);
  packed_rows_ = (strip_rows_ - 1) * vertical_.stride + row_span_;
  packed_columns_ = (strip_columns_ - 1) * horizontal_.stride + column_span_;
  lane_columns_ = divide_up(packed_columns_, horizontal_.stride);
  row_pitch_ = std::ptrdiff_t{lane_columns_} * horizontal_.stride * pixel_pitch_;
  block_pitch_ = row_pitch_ * packed_rows_;
}

std::size_t StripGrid::packed_size() const {
  return static_cast<std::size_t>(block_pitch_ * blocks_);
}

Strip StripGrid::strip(int index) const {
  Strip strip;
  strip.first_column = index % column_strips_ * strip_columns_;
  strip.first_row = index / column_strips_ % row_strips_ * strip_rows_;
  strip.image = index / column_strips_ / row_strips_;
  strip.rows = std::min(strip_rows_, vertical_.cells(0) - strip.first_row);
  strip.columns = std::min(strip_columns_, horizontal_.cells(0) - strip.first_column);
  return strip;
}

std::ptrdiff_t StripGrid::tap_position(int row_offset, int column_offset) const {
  const int column = column_offset - column_base_;
  const int position = column % horizontal_.stride * lane_columns_ + column / horizontal_.stride;
  return (row_offset - row_base_) * row_pitch_ + std::ptrdiff_t{position} * pixel_pitch_;
}

StripCopy StripGrid::copy(const Strip& strip, const float* x, float* packed) const {
  StripCopy copy{};
  copy.image = x + std::ptrdiff_t{strip.image} * vertical_.in * horizontal_.in * channels_;
  copy.height = vertical_.in;
  copy.width = horizontal_.in;
  copy.channels = channels_;
  copy.first_row = strip.first_row * vertical_.stride + row_base_;
  copy.first_column = strip.first_column * horizontal_.stride + column_base_;
  copy.rows = (strip.rows - 1) * vertical_.stride + row_span_;
  copy.columns = (strip.columns - 1) * horizontal_.stride + column_span_;
  copy.stride = horizontal_.stride;
  copy.lane_columns = lane_columns_;
  copy.pixel_pitch = pixel_pitch_;
  copy.row_pitch = row_pitch_;
  copy.block_pitch = block_pitch_;
  copy.packed = packed;
  return copy;
}

}  // namespace imslam::nn::kernels

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
                     StripLimits limits)
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
  fit(limits);
  while (block_pitch_ * blocks_ > kMostFloats && rows_.longest() > 1) {
    limits.cells /= 2;
    fit(limits);
  }
  while (block_pitch_ * blocks_ > kMostFloats && columns_.longest() > kFewColumns) {
    limits.columns /= 2;
    fit(limits);
  }
}

void StripGrid::fit(const StripLimits& limits) {
  const bool edges = limits.edge_columns > 0;
  const int reach_y = std::max(-row_base_, row_base_ + row_span_ - 1);
  const int reach_x = std::max(-column_base_, column_base_ + column_span_ - 1);
  const int edge_rows = edges ? divide_up(std::max(0, reach_y), vertical_.stride) : 0;
  columns_ = AxisCuts(horizontal_.cells(0), reach_x > 0 ? limits.edge_columns : 0, limits.columns);
  rows_ = AxisCuts(vertical_.cells(0), edge_rows, limits.cells / columns_.longest());
  lane_columns_ =
      divide_up((columns_.longest() - 1) * horizontal_.stride + column_span_, horizontal_.stride);
  row_pitch_ = std::ptrdiff_t{lane_columns_} * horizontal_.stride * pixel_pitch_;
  block_pitch_ = row_pitch_ * ((rows_.longest() - 1) * vertical_.stride + row_span_);
}

std::size_t StripGrid::packed_size() const {
  return static_cast<std::size_t>(block_pitch_ * blocks_);
}

Strip StripGrid::strip(int index) const {
  const int column = index % columns_.count();
  const int row = index / columns_.count() % rows_.count();
  Strip strip;
  strip.image = index / columns_.count() / rows_.count();
  strip.first_row = rows_.begin(row);
  strip.rows = rows_.begin(row + 1) - strip.first_row;
  strip.first_column = columns_.begin(column);
  strip.columns = columns_.begin(column + 1) - strip.first_column;
  const int y = strip.first_row * vertical_.stride + row_base_;
  const int x = strip.first_column * horizontal_.stride + column_base_;
  strip.inside = y >= 0 && x >= 0 &&
                 y + (strip.rows - 1) * vertical_.stride + row_span_ <= vertical_.in &&
                 x + (strip.columns - 1) * horizontal_.stride + column_span_ <= horizontal_.in;
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

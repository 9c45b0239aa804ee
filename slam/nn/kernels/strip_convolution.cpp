#include "slam/nn/kernels/strip_convolution.hpp"

#include <algorithm>

#include "slam/base/parallel.hpp"
#include "slam/nn/kernels/channel_groups.hpp"
#include "slam/nn/kernels/strip_grid.hpp"

namespace imslam::nn::kernels {
namespace {

constexpr int kMostColumns = 84;       // three tiles of 28 or six of 14
constexpr int kStripCells = 8 * 84;    // rows are packed (rows + halo) / rows times
constexpr double kTaskProducts = 1e6;  // less is not worth a task

struct Job {
  const StripConvolution& convolution;
  const KernelTable& table;
  const ChannelGroups groups;
  const StripGrid grid;
  const float* x;
  const float* packed_weights;
  float negative_slope;
  float* y;
  const std::ptrdiff_t* taps;  // of all phases, in the order of the weights
  Workspace& workspace;
};

/// What the phase (i, j) of a cell reads and writes.
struct Phase {
  int row, column;
  int rows, columns;  // cells of this strip that have an output in this phase
  int tap_count;
  const std::ptrdiff_t* taps;
  const float* weights;
};

void multiply_group(const Job& job,
                    const Strip& strip,
                    const Phase& phase,
                    const ChannelGroup& group,
                    const float* packed) {
  const StripConvolution& c = job.convolution;
  RowProduct row{};
  row.pixel_pitch = job.grid.pixel_pitch();
  row.blocks = job.grid.blocks();
  row.last_channels = job.grid.last_channels();
  row.block_pitch = job.grid.block_pitch();
  row.taps = phase.taps;
  row.tap_count = phase.tap_count * job.grid.channels_as_taps();
  row.weights =
      phase.weights + std::ptrdiff_t{group.first_channel} * phase.tap_count * c.in_channels;
  row.bias = job.packed_weights + group.first_channel;
  row.output_pitch = std::ptrdiff_t{c.horizontal.step} * c.out_channels;
  row.pixels = phase.columns;
  row.packets = group.packets;
  row.last_lanes = group.last_lanes;
  row.negative_slope = job.negative_slope;
  for (int r = 0; r < phase.rows; ++r) {
    const int y = (strip.first_row + r) * c.vertical.step + phase.row;
    const int x = strip.first_column * c.horizontal.step + phase.column;
    const std::ptrdiff_t pixel =
        (std::ptrdiff_t{strip.image} * c.vertical.out + y) * c.horizontal.out + x;
    row.input = packed + r * c.vertical.stride * job.grid.row_pitch();
    row.output = job.y + pixel * c.out_channels + group.first_channel;
    job.table.row_product(row);
  }
}

void convolve_strip(const Job& job, const Strip& strip, float* packed) {
  const StripConvolution& c = job.convolution;
  job.table.copy_strip(job.grid.copy(strip, job.x, packed));
  Phase phase{};
  phase.taps = job.taps;
  phase.weights = job.packed_weights + job.groups.padded();
  for (phase.row = 0; phase.row < c.vertical.step; ++phase.row) {
    phase.rows = std::min(strip.rows, c.vertical.cells(phase.row) - strip.first_row);
    for (phase.column = 0; phase.column < c.horizontal.step; ++phase.column) {
      phase.columns =
          std::min(strip.columns, c.horizontal.cells(phase.column) - strip.first_column);
      phase.tap_count = c.vertical.taps(phase.row).count * c.horizontal.taps(phase.column).count;
      for (int g = 0; g < job.groups.count() && phase.columns > 0; ++g) {
        multiply_group(job, strip, phase, job.groups.group(g), packed);
      }
      phase.taps += phase.tap_count * job.grid.channels_as_taps();
      phase.weights += std::ptrdiff_t{phase.tap_count} * c.in_channels * job.groups.padded();
    }
  }
}

void place_taps(const StripConvolution& convolution, const StripGrid& grid, std::ptrdiff_t* to) {
  for (int i = 0; i < convolution.vertical.step; ++i) {
    const AxisTaps rows = convolution.vertical.taps(i);
    for (int j = 0; j < convolution.horizontal.step; ++j) {
      const AxisTaps columns = convolution.horizontal.taps(j);
      for (int k = 0; k < rows.count; ++k) {
        for (int l = 0; l < columns.count; ++l) {
          const std::ptrdiff_t tap =
              grid.tap_position(rows.first_offset + k * rows.offset_step,
                                columns.first_offset + l * columns.offset_step);
          for (int c = 0; c < grid.channels_as_taps(); ++c) *to++ = tap + c;
        }
      }
    }
  }
}

ConvolutionAxis backward(const ConvolutionAxis& forward) {
  ConvolutionAxis axis = forward;
  std::swap(axis.in, axis.out);
  std::swap(axis.stride, axis.step);
  axis.backward = true;
  return axis;
}

}  // namespace

StripConvolution StripConvolution::forward(const ConvolutionShape& shape) {
  StripConvolution c;
  c.vertical = {shape.in_height,     shape.out_height(), shape.stride_y,   1,
                shape.kernel_height, shape.padding_y,    shape.dilation_y, false};
  c.horizontal = {shape.in_width,     shape.out_width(), shape.stride_x,   1,
                  shape.kernel_width, shape.padding_x,   shape.dilation_x, false};
  c.batch = shape.batch;
  c.in_channels = shape.in_channels;
  c.out_channels = shape.out_channels;
  return c;
}

StripConvolution StripConvolution::backward_data(const ConvolutionShape& shape) {
  StripConvolution c = forward(shape);
  c.vertical = backward(c.vertical);
  c.horizontal = backward(c.horizontal);
  std::swap(c.in_channels, c.out_channels);
  return c;
}

void convolve_strips(const StripConvolution& convolution,
                     const float* x,
                     const float* packed_weights,
                     float negative_slope,
                     const KernelTable& table,
                     float* y,
                     Workspace& workspace) {
  const int all_taps = convolution.vertical.kernel * convolution.horizontal.kernel;
  const StripGrid grid(convolution.vertical, convolution.horizontal, convolution.batch,
                       convolution.in_channels, kMostColumns, kStripCells);
  std::ptrdiff_t* taps =
      workspace.positions(static_cast<std::size_t>(all_taps * grid.channels_as_taps()));
  place_taps(convolution, grid, taps);
  const Job job{convolution,    table, ChannelGroups(convolution.out_channels, table),
                grid,           x,     packed_weights,
                negative_slope, y,     taps,
                workspace};

  const double products = double(grid.strip_rows()) * grid.strip_columns() * all_taps *
                          convolution.in_channels * convolution.out_channels;
  const int strips_per_task = std::max(1, static_cast<int>(kTaskProducts / products));
  const int tasks = (grid.count() + strips_per_task - 1) / strips_per_task;
  const auto task = [&job, strips_per_task](std::size_t index) {
    const Workspace::Lease packed(job.workspace, job.grid.packed_size());
    const int first = static_cast<int>(index) * strips_per_task;
    const int last = std::min(first + strips_per_task, job.grid.count());
    for (int s = first; s < last; ++s) convolve_strip(job, job.grid.strip(s), packed.data());
  };
  if (tasks == 1) return task(0);
  parallel_for(static_cast<std::size_t>(tasks), task);
}

}  // namespace imslam::nn::kernels

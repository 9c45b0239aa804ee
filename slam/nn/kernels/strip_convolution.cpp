#include "slam/nn/kernels/strip_convolution.hpp"

#include <algorithm>

#include "slam/base/parallel.hpp"
#include "slam/nn/kernels/channel_groups.hpp"
#include "slam/nn/kernels/strip_grid.hpp"

namespace imslam::nn::kernels {
namespace {

// Three tiles of 28 columns or six of 14; rows are packed (rows + halo) / rows times.
constexpr StripLimits kLimits = {84, 8 * 84, 0};
constexpr StripLimits kDirectLimits = {84, 16 * 84, 14};
constexpr double kTaskProducts = 1e6;  // less is not worth a task

struct Job {
  const StripConvolution& convolution;
  const KernelTable& table;
  const ChannelGroups groups;
  const bool narrow;
  const int weight_channels;
  const StripGrid grid;
  const float* x;
  const float* packed_weights;
  float negative_slope;
  float* y;
  const std::ptrdiff_t* taps;         // of all phases, in the order of the weights
  const std::ptrdiff_t* direct_taps;  // likewise, in the image itself; null: never read it in place
  Workspace& workspace;
};

/// What the phase (i, j) of a cell reads and writes.
struct Phase {
  int row, column;
  int rows, columns;  // cells of this strip that have an output in this phase
  int tap_count;
  const std::ptrdiff_t* taps;
  const std::ptrdiff_t* direct_taps;
  const float* weights;
};

/// The input as it lies in the packed strip, or in the image where the strip is inside of it.
RowProduct describe_input(const Job& job, const Strip& strip, const Phase& phase, bool direct) {
  const StripConvolution& c = job.convolution;
  RowProduct row{};
  const int channels_as_taps = job.grid.channels_as_taps();
  row.last_channels = channels_as_taps > 1 ? 1 : job.grid.last_channels();
  row.blocks = job.grid.blocks();
  row.tap_count = phase.tap_count * channels_as_taps;
  if (direct) {
    row.pixel_pitch = c.horizontal.stride * c.in_channels;
    row.block_pitch = kBlock;
    row.taps = phase.direct_taps;
    const std::ptrdiff_t y = std::ptrdiff_t{strip.image} * c.vertical.in +
                             std::ptrdiff_t{strip.first_row} * c.vertical.stride;
    const std::ptrdiff_t x = std::ptrdiff_t{strip.first_column} * c.horizontal.stride;
    row.input = job.x + (y * c.horizontal.in + x) * c.in_channels;
  } else {
    row.pixel_pitch = job.grid.pixel_pitch();
    row.block_pitch = job.grid.block_pitch();
    row.taps = phase.taps;
  }
  return row;
}

void multiply_group(const Job& job,
                    const Strip& strip,
                    const Phase& phase,
                    const ChannelGroup& group,
                    const float* packed) {
  const StripConvolution& c = job.convolution;
  const bool direct = packed == nullptr;
  RowProduct row = describe_input(job, strip, phase, direct);
  const float* const input = direct ? row.input : packed;
  const std::ptrdiff_t row_step =
      c.vertical.stride *
      (direct ? std::ptrdiff_t{c.horizontal.in} * c.in_channels : job.grid.row_pitch());
  row.weights =
      phase.weights + std::ptrdiff_t{group.first_channel} * phase.tap_count * job.weight_channels;
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
    row.input = input + r * row_step;
    row.next = r + 1 < phase.rows ? row.input + row_step : input;
    row.output = job.y + pixel * c.out_channels + group.first_channel;
    job.narrow ? job.table.narrow_product(row) : job.table.row_product(row);
  }
}

void convolve_strip(const Job& job, const Strip& strip, float* packed) {
  const StripConvolution& c = job.convolution;
  if (strip.inside && job.direct_taps != nullptr) packed = nullptr;
  if (packed != nullptr) job.table.copy_strip(job.grid.copy(strip, job.x, packed));
  Phase phase{};
  phase.taps = job.taps;
  phase.direct_taps = job.direct_taps;
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
      const int positions = phase.tap_count * job.grid.channels_as_taps();
      phase.taps += positions;
      if (phase.direct_taps != nullptr) phase.direct_taps += positions;
      phase.weights += std::ptrdiff_t{phase.tap_count} * job.weight_channels * job.groups.padded();
    }
  }
}

/// Calls place(row offset, column offset) for the taps of all phases in the order of the weights.
template <typename Place>
void for_each_tap(const StripConvolution& convolution, const Place& place) {
  for (int i = 0; i < convolution.vertical.step; ++i) {
    const AxisTaps rows = convolution.vertical.taps(i);
    for (int j = 0; j < convolution.horizontal.step; ++j) {
      const AxisTaps columns = convolution.horizontal.taps(j);
      for (int k = 0; k < rows.count; ++k) {
        for (int l = 0; l < columns.count; ++l) {
          place(rows.first_offset + k * rows.offset_step,
                columns.first_offset + l * columns.offset_step);
        }
      }
    }
  }
}

/// Pixels further apart collide in the first-level cache when they are read in place, and a narrow
/// group of output channels does not pay for addresses that the compiler does not know.
bool reads_in_place(const StripConvolution& convolution, const KernelTable& table) {
  constexpr int kMostDirectChannels = 96;
  const int channels = convolution.in_channels;
  const int pitch = convolution.horizontal.stride * channels;
  if (channels <= 4) return pitch == 1 || pitch == 3 || pitch == 4 || pitch == 6;
  if (convolution.is_narrow(table)) return channels % kBlock == 0;
  if (convolution.out_channels <= table.lanes) return pitch == kBlock || pitch == 2 * kBlock;
  return channels <= kMostDirectChannels;
}

void place_taps(const StripConvolution& convolution,
                const StripGrid& grid,
                std::ptrdiff_t* packed,
                std::ptrdiff_t* direct) {
  for_each_tap(convolution, [&](int row, int column) {
    const std::ptrdiff_t position = grid.tap_position(row, column);
    const std::ptrdiff_t pixel = std::ptrdiff_t{row} * convolution.horizontal.in + column;
    for (int c = 0; c < grid.channels_as_taps(); ++c) {
      *packed++ = position + c;
      *direct++ = pixel * convolution.in_channels + c;
    }
  });
}

}  // namespace

void convolve_strips(const StripConvolution& convolution,
                     const float* x,
                     const float* packed_weights,
                     float negative_slope,
                     const KernelTable& table,
                     float* y,
                     Workspace& workspace) {
  const int all_taps = convolution.vertical.kernel * convolution.horizontal.kernel;
  const bool direct = reads_in_place(convolution, table);
  const StripGrid grid(convolution.vertical, convolution.horizontal, convolution.batch,
                       convolution.in_channels, direct ? kDirectLimits : kLimits);
  const int positions = all_taps * grid.channels_as_taps();
  std::ptrdiff_t* taps = workspace.positions(static_cast<std::size_t>(2 * positions));
  place_taps(convolution, grid, taps, taps + positions);
  const Job job{convolution,
                table,
                convolution.groups(table),
                convolution.is_narrow(table),
                convolution.weight_channels(table),
                grid,
                x,
                packed_weights,
                negative_slope,
                y,
                taps,
                direct ? taps + positions : nullptr,
                workspace};

  const double products = double(grid.most_rows()) * grid.longest_row() * all_taps *
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

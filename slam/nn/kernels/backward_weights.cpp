#include <algorithm>

#include "slam/base/parallel.hpp"
#include "slam/nn/kernels/channel_groups.hpp"
#include "slam/nn/kernels/convolution.hpp"
#include "slam/nn/kernels/instruction_set.hpp"
#include "slam/nn/kernels/prefetch_cursor.hpp"
#include "slam/nn/kernels/strip_convolution.hpp"
#include "slam/nn/kernels/strip_grid.hpp"

namespace imslam::nn {
namespace kernels {
namespace {

// A tile of sums takes 160 pixels between its load and its store.
constexpr StripLimits kLimits = {80, 160, 0};
constexpr int kChunkPixels = 900;  // a chunk has its own sums, so it should not be small
constexpr int kMostChunks = 8;

struct Job {
  const StripConvolution& convolution;
  const KernelTable& table;
  const ChannelGroups groups;
  const StripGrid grid;
  const float* x;
  const float* dy;
  const std::ptrdiff_t* taps;
  int tap_count;
  Workspace& workspace;

  std::size_t sums_size() const {
    return static_cast<std::size_t>(groups.padded()) *
           (static_cast<std::size_t>(tap_count) *
                static_cast<std::size_t>(convolution.in_channels) +
            1);
  }
};

/// dy of the strip for one group of channels -> packed; its sum -> bias_sum.
void pack_gradient(
    const Job& job, const Strip& strip, const ChannelGroup& group, float* packed, float* bias_sum) {
  const StripConvolution& c = job.convolution;
  for (int r = 0; r < strip.rows; ++r) {
    const std::ptrdiff_t pixel =
        (std::ptrdiff_t{strip.image} * c.vertical.out + strip.first_row + r) * c.horizontal.out +
        strip.first_column;
    GradientCopy copy{};
    copy.dy = job.dy + pixel * c.out_channels + group.first_channel;
    copy.pixel_pitch = c.out_channels;
    copy.pixels = strip.columns;
    copy.packets = group.packets;
    copy.last_lanes = group.last_lanes;
    copy.packed = packed + std::ptrdiff_t{r} * strip.columns * group.packets * job.groups.lanes();
    copy.sum = bias_sum;
    job.table.copy_gradient(copy);
  }
}

/// What a strip reads of x and of dy.
struct StripMemory {
  PrefetchCursor x, dy;

  void hint(OuterProduct& product) {
    PrefetchCursor& cursor = dy.empty() ? x : dy;
    if (cursor.empty()) {
      product.hint = product.hint_end;
      return;
    }
    const PrefetchCursor::Portion portion = cursor.next(product.rows * product.pixels);
    product.hint = portion.begin;
    product.hint_end = portion.end;
  }
};

StripMemory memory_of(const Job& job, const Strip& strip) {
  const StripConvolution& c = job.convolution;
  const StripCopy copy = job.grid.copy(strip, job.x, nullptr);
  const int first_row = std::max(0, copy.first_row);
  const int first_column = std::max(0, copy.first_column);
  const int rows = std::min(copy.first_row + copy.rows, copy.height) - first_row;
  const int columns = std::min(copy.first_column + copy.columns, copy.width) - first_column;
  StripMemory memory;
  if (rows > 0 && columns > 0) {
    const std::ptrdiff_t pitch = std::ptrdiff_t{copy.width} * copy.channels;
    memory.x = {copy.image + first_row * pitch + std::ptrdiff_t{first_column} * copy.channels,
                std::ptrdiff_t{columns} * copy.channels, pitch, rows};
  }
  const std::ptrdiff_t row = std::ptrdiff_t{strip.image} * c.vertical.out + strip.first_row;
  memory.dy = {job.dy + (row * c.horizontal.out + strip.first_column) * c.out_channels,
               std::ptrdiff_t{strip.columns} * c.out_channels,
               std::ptrdiff_t{c.horizontal.out} * c.out_channels, strip.rows};
  return memory;
}

/// sums: [bias], then for each group [tap, input channel, output channel].
void accumulate_strip(
    const Job& job, const Strip& strip, StripMemory next, float* packed, float* sums) {
  const int inputs = job.convolution.in_channels;
  job.table.copy_strip(job.grid.copy(strip, job.x, packed));
  float* const packed_dy = packed + job.grid.packed_size();
  OuterProduct product{};
  product.x_row_pitch = job.convolution.vertical.stride * job.grid.row_pitch();
  product.pixel_pitch = job.grid.pixel_pitch();
  product.rows = strip.rows;
  product.pixels = strip.columns;
  product.dy = packed_dy;
  for (int g = 0; g < job.groups.count(); ++g) {
    const ChannelGroup group = job.groups.group(g);
    const int width = group.packets * job.groups.lanes();
    pack_gradient(job, strip, group, packed_dy, sums + group.first_channel);
    float* const group_sums =
        sums + job.groups.padded() + std::ptrdiff_t{group.first_channel} * job.tap_count * inputs;
    product.packets = group.packets;
    if (job.grid.pixel_pitch() < kBlock) {
      product.x = packed;
      product.taps = job.taps;
      product.channels = job.tap_count * inputs;
      product.sum = group_sums;
      next.hint(product);
      job.table.outer_product(product);
      continue;
    }
    for (int b = 0; b < job.grid.blocks(); ++b) {
      product.channels = std::min(kBlock, inputs - b * kBlock);
      for (int tap = 0; tap < job.tap_count; ++tap) {
        product.x = packed + b * job.grid.block_pitch() + job.taps[tap];
        product.sum = group_sums + (std::ptrdiff_t{tap} * inputs + b * kBlock) * width;
        next.hint(product);
        job.table.outer_product(product);
      }
    }
  }
}

/// The sums of chunk 0 become those of all chunks, added in order.
void add_chunks(float* sums, std::size_t size, int chunks) {
  for (int chunk = 1; chunk < chunks; ++chunk) {
    const float* other = sums + static_cast<std::size_t>(chunk) * size;
    for (std::size_t i = 0; i < size; ++i) sums[i] += other[i];
  }
}

void unpack(const Job& job, const float* sums, float* dw, float* db) {
  const int outputs = job.convolution.out_channels;
  if (db != nullptr) std::copy_n(sums, outputs, db);
  sums += job.groups.padded();
  for (int g = 0; g < job.groups.count(); ++g) {
    const ChannelGroup group = job.groups.group(g);
    const int width = group.packets * job.groups.lanes();
    const int used = width - job.groups.lanes() + group.last_lanes;
    const std::ptrdiff_t rows = std::ptrdiff_t{job.tap_count} * job.convolution.in_channels;
    for (std::ptrdiff_t r = 0; r < rows; ++r, sums += width) {
      std::copy_n(sums, used, dw + r * outputs + group.first_channel);
    }
  }
}

void sum_outer_products(const Job& job, float* dw, float* db) {
  const std::size_t size = job.sums_size();
  const int strips = job.grid.count();
  const double pixels = double(strips) * job.grid.most_rows() * job.grid.longest_row();
  const int chunks = std::min(
      strips, static_cast<int>(std::clamp(pixels / kChunkPixels, 1.0, double(kMostChunks))));
  float* const sums = job.workspace.buffer(1, size * static_cast<std::size_t>(chunks));
  const auto chunk = [&job, sums, size, strips, chunks](std::size_t index) {
    const std::size_t dy_size =
        static_cast<std::size_t>(job.grid.most_rows()) *
        static_cast<std::size_t>(job.grid.longest_row()) *
        static_cast<std::size_t>(job.table.most_packets * job.groups.lanes());
    const Workspace::Lease packed(job.workspace, job.grid.packed_size() + dy_size);
    float* const own = sums + index * size;
    std::fill_n(own, size, 0.0F);
    const int i = static_cast<int>(index);
    for (int s = strips * i / chunks; s < strips * (i + 1) / chunks; ++s) {
      const bool last = s + 1 == strips;
      const StripMemory next = last ? StripMemory{} : memory_of(job, job.grid.strip(s + 1));
      accumulate_strip(job, job.grid.strip(s), next, packed.data(), own);
    }
  };
  if (chunks == 1) chunk(0);
  if (chunks > 1) parallel_for(static_cast<std::size_t>(chunks), chunk);
  add_chunks(sums, size, chunks);
  unpack(job, sums, dw, db);
}

}  // namespace
}  // namespace kernels

void convolution_backward_weights(const ConvolutionShape& shape,
                                  const float* x,
                                  const float* dy,
                                  float* dw,
                                  float* db,
                                  Workspace* workspace) {
  shape.validate();
  Workspace own;
  if (workspace == nullptr) workspace = &own;
  const auto convolution = kernels::StripConvolution::forward(shape);
  const kernels::KernelTable& table = kernels::selected_kernels();
  const kernels::StripGrid grid(convolution.vertical, convolution.horizontal, shape.batch,
                                shape.in_channels, kernels::kLimits);
  const int tap_count = shape.kernel_height * shape.kernel_width;
  const int channels_as_taps = grid.channels_as_taps();
  std::ptrdiff_t* taps =
      workspace->positions(static_cast<std::size_t>(tap_count * channels_as_taps));
  for (int i = 0; i < tap_count * channels_as_taps; ++i) {
    const int tap = i / channels_as_taps;
    taps[i] = i % channels_as_taps +
              grid.tap_position(tap / shape.kernel_width * shape.dilation_y - shape.padding_y,
                                tap % shape.kernel_width * shape.dilation_x - shape.padding_x);
  }
  const kernels::ChannelGroups groups(shape.out_channels, table.lanes, table.most_packets);
  kernels::sum_outer_products(
      {convolution, table, groups, grid, x, dy, taps, tap_count, *workspace}, dw, db);
}

}  // namespace imslam::nn

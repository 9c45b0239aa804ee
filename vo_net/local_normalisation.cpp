#include "vo_net/local_normalisation.hpp"

#include <cmath>
#include <functional>

#include "slam/base/parallel.hpp"
#include "vo_net/options_check.hpp"

namespace imslam::vo {
namespace {

using nn::Index;

constexpr Index kRowsPerTask = 128;  // fixed: sums do not depend on the number of threads
constexpr Index kScales = 2;

/// Sums of I and I^2 over the columns of a band of rows that slides down the image.
struct ColumnSums {
  double* value;   ///< [W]
  double* square;  ///< [W]

  template <typename S>
  void add(const S* row, Index width, double sign) const {
    for (Index j = 0; j < width; ++j) {
      const auto x = static_cast<double>(row[j]);
      value[j] += sign * x;
      square[j] += sign * x * x;
    }
  }
};

/// prefix[j] = sum of columns before j.
void accumulate(const double* columns, Index width, double* prefix) {
  prefix[0] = 0.0;
  for (Index j = 0; j < width; ++j) prefix[j + 1] = prefix[j] + columns[j];
}

/// One scale of a band of rows of one image; y is the first of its numbers, kScales apart.
template <typename S>
struct Band {
  const S* image;
  S* y;
  Index height;
  Index width;
  Index radius;
  double floor_squared;

  static Index scratch_size(Index width) { return 4 * width + 2; }

  void normalise(Index begin, Index end, double* scratch) const {
    const ColumnSums sums{scratch, scratch + width};
    double* const prefix = scratch + 2 * width;
    double* const prefix_of_squares = prefix + width + 1;
    std::fill_n(scratch, 2 * width, 0.0);
    for (Index i = std::max<Index>(0, begin - radius); i < std::min(height, begin + radius); ++i) {
      sums.add(image + i * width, width, 1.0);
    }
    for (Index i = begin; i < end; ++i) {
      if (i + radius < height) sums.add(image + (i + radius) * width, width, 1.0);
      if (i > begin && i - radius - 1 >= 0) {
        sums.add(image + (i - radius - 1) * width, width, -1.0);
      }
      accumulate(sums.value, width, prefix);
      accumulate(sums.square, width, prefix_of_squares);
      expects(std::isfinite(prefix_of_squares[width]),
              "local_normalisation: all pixels must be finite");
      const Index rows = std::min(height - 1, i + radius) - std::max<Index>(0, i - radius) + 1;
      normalise_row(i, rows, prefix, prefix_of_squares);
    }
  }

  void normalise_row(Index i, Index rows, const double* sum, const double* sum_of_squares) const {
    for (Index j = 0; j < width; ++j) {
      const Index first = std::max<Index>(0, j - radius);
      const Index last = std::min(width - 1, j + radius) + 1;
      const auto count = static_cast<double>(rows * (last - first));
      const double mean = (sum[last] - sum[first]) / count;  // exact where whole numbers are equal
      const double square = (sum_of_squares[last] - sum_of_squares[first]) / count;
      const double variance = std::max(0.0, square - mean * mean);
      const double z =
          (static_cast<double>(image[i * width + j]) - mean) / std::sqrt(variance + floor_squared);
      y[(i * width + j) * kScales] = static_cast<S>(z);
    }
  }
};

}  // namespace

void LocalNormalisationOptions::describe(Config& config) {
  config.field("small_radius", small_radius, "of the windows that show texture [px]");
  config.field("large_radius", large_radius, "of the windows that show shape [px]");
  config.field("noise_floor", noise_floor, "contrast that is not amplified any more [grey levels]");
}

void LocalNormalisationOptions::validate() const {
  require(small_radius >= 1 && small_radius <= 1000, "small_radius", small_radius, "1 .. 1000");
  require(large_radius >= small_radius && large_radius <= 1000, "large_radius", large_radius,
          "small_radius .. 1000");
  require(noise_floor > 0.0 && noise_floor <= 255.0, "noise_floor", noise_floor, "0 .. 255, not 0");
}

template <typename S>
nn::Var local_normalisation(nn::Tape<S>& tape,
                            nn::Var image,
                            const LocalNormalisationOptions& options) {
  const nn::Shape shape = tape.shape(image);
  nn::expects_shape(shape.rank() == 4 && shape[3] == 1, "local_normalisation: image [N,H,W,1]",
                    shape);
  const nn::Var y = tape.make(shape.with_channels(kScales));
  const Index height = shape[1];
  const Index width = shape[2];
  const Index bands = (height + kRowsPerTask - 1) / kRowsPerTask;
  const Index tasks = shape[0] * bands;
  const Index scratch_size = Band<S>::scratch_size(width);
  nn::Scratch<S> scratch(tape);
  double* const memory = scratch.template array<double>(tasks * scratch_size);
  const S* const I = tape.data(image);
  S* const Y = tape.data(y);
  const auto task = [&](std::size_t t) {
    const auto number = static_cast<Index>(t);
    const Index first_pixel = number / bands * height * width;
    const Index begin = number % bands * kRowsPerTask;
    for (Index scale = 0; scale < kScales; ++scale) {
      const Index radius = scale == 0 ? options.small_radius : options.large_radius;
      const Band<S> band{I + first_pixel, Y + first_pixel * kScales + scale,        height, width,
                         radius,          options.noise_floor * options.noise_floor};
      band.normalise(begin, std::min(begin + kRowsPerTask, height), memory + number * scratch_size);
    }
  };
  parallel_for(static_cast<std::size_t>(tasks), std::cref(task));
  return y;
}

template nn::Var local_normalisation(nn::Tape<float>&, nn::Var, const LocalNormalisationOptions&);
template nn::Var local_normalisation(nn::Tape<double>&, nn::Var, const LocalNormalisationOptions&);

}  // namespace imslam::vo

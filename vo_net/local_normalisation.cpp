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
  void add(const S* row, Index width) const {
    for (Index j = 0; j < width; ++j) {
      const auto x = static_cast<double>(row[j]);
      value[j] += x;
      square[j] += x * x;
    }
  }
  template <typename S>
  void subtract(const S* row, Index width) const {
    for (Index j = 0; j < width; ++j) {
      const auto x = static_cast<double>(row[j]);
      value[j] -= x;
      square[j] -= x * x;
    }
  }
  template <typename S>
  void exchange(const S* enters, const S* leaves, Index width) const {
    for (Index j = 0; j < width; ++j) {
      const auto x = static_cast<double>(enters[j]);
      const auto z = static_cast<double>(leaves[j]);
      value[j] += x - z;
      square[j] += x * x - z * z;
    }
  }
};

/// One scale of a band of rows of one image; y is the first of its numbers, kScales apart.
template <typename S>
class Band {
 public:
  struct Image {
    const S* pixels;
    Index height;
    Index width;
  };

  // Numbers of scratch that normalise() needs.
  static Index scratch_size(Index width) { return 4 * width + 2; }
  static Index row_size(Index width) { return 2 * width; }

  Band(const Image& image, Index radius, double noise_floor, double* scratch, S* rows, S* y)
      : image_(image),
        radius_(radius),
        floor_squared_(noise_floor * noise_floor),
        columns_{scratch, scratch + image.width},
        sum_(scratch + 2 * image.width),
        sum_of_squares_(sum_ + image.width + 1),
        deviation_(rows),
        spread_(deviation_ + image.width),
        y_(y) {}

  void normalise(Index begin, Index end) {
    std::fill_n(columns_.value, 2 * image_.width, 0.0);
    const Index first = std::max<Index>(0, begin - radius_);
    for (Index i = first; i < std::min(image_.height, begin + radius_); ++i) {
      columns_.add(row(i), image_.width);
    }
    for (Index i = begin; i < end; ++i) {
      slide(i + radius_, i > begin ? i - radius_ - 1 : -1);
      accumulate_columns();
      const Index last = std::min(image_.height - 1, i + radius_);
      normalise_row(i, last - std::max<Index>(0, i - radius_) + 1);
    }
  }

 private:
  const S* row(Index i) const { return image_.pixels + i * image_.width; }

  void slide(Index enters, Index leaves) const {
    if (enters < image_.height && leaves >= 0) {
      columns_.exchange(row(enters), row(leaves), image_.width);
    } else if (enters < image_.height) {
      columns_.add(row(enters), image_.width);
    } else if (leaves >= 0) {
      columns_.subtract(row(leaves), image_.width);
    }
  }

  /// sum_[j] = sum of the columns before j.
  void accumulate_columns() {
    double sum = 0.0;
    double squares = 0.0;
    for (Index j = 0; j < image_.width; ++j) {
      sum_[j] = sum;
      sum_of_squares_[j] = squares;
      sum += columns_.value[j];
      squares += columns_.square[j];
    }
    sum_[image_.width] = sum;
    sum_of_squares_[image_.width] = squares;
    expects(std::isfinite(squares), "local_normalisation: all pixels must be finite");
  }

  /// z = (n I - sum) / sqrt(n sum of squares - sum^2 + (n floor)^2), which is exact for flat images
  /// of whole grey levels.
  void normalise_row(Index i, Index rows) {
    const Index width = image_.width;
    const S* const pixels = row(i);
    const Index inner_begin = std::min(radius_, width);
    const Index inner_end = std::max(inner_begin, width - radius_);
    for (Index j = 0; j < inner_begin; ++j) compare_clipped(pixels[j], j, rows);
    const auto count = static_cast<double>(rows * (2 * radius_ + 1));
    for (Index j = inner_begin; j < inner_end; ++j) {
      compare(pixels[j], j, j - radius_, j + radius_ + 1, count);
    }
    for (Index j = inner_end; j < width; ++j) compare_clipped(pixels[j], j, rows);

    using Row = Eigen::Map<Eigen::Array<S, Eigen::Dynamic, 1>>;
    Row z(deviation_, width);
    z /= Row(spread_, width).sqrt();
    for (Index j = 0; j < width; ++j) y_[(i * width + j) * kScales] = deviation_[j];
  }

  void compare_clipped(S pixel, Index j, Index rows) {
    const Index first = std::max<Index>(0, j - radius_);
    const Index end = std::min(image_.width, j + radius_ + 1);
    compare(pixel, j, first, end, static_cast<double>(rows * (end - first)));
  }

  void compare(S pixel, Index j, Index first, Index end, double count) {
    const double sum = sum_[end] - sum_[first];
    const double squares = sum_of_squares_[end] - sum_of_squares_[first];
    const double variance = count * squares - sum * sum;
    deviation_[j] = static_cast<S>(count * static_cast<double>(pixel) - sum);
    spread_[j] = static_cast<S>((variance > 0.0 ? variance : 0.0) + count * count * floor_squared_);
  }

  Image image_;
  Index radius_;
  double floor_squared_;
  ColumnSums columns_;
  double* sum_;             ///< [W + 1]
  double* sum_of_squares_;  ///< [W + 1]
  S* deviation_;            ///< [W]
  S* spread_;               ///< [W]
  S* y_;
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
  const Index row_size = Band<S>::row_size(width);
  S* const rows = scratch.template array<S>(tasks * row_size);
  const S* const I = tape.data(image);
  S* const Y = tape.data(y);
  const auto task = [&](std::size_t t) {
    const auto number = static_cast<Index>(t);
    const Index first_pixel = number / bands * height * width;
    const Index begin = number % bands * kRowsPerTask;
    for (Index scale = 0; scale < kScales; ++scale) {
      const Index radius = scale == 0 ? options.small_radius : options.large_radius;
      Band<S> band({I + first_pixel, height, width}, radius, options.noise_floor,
                   memory + number * scratch_size, rows + number * row_size,
                   Y + first_pixel * kScales + scale);
      band.normalise(begin, std::min(begin + kRowsPerTask, height));
    }
  };
  parallel_for(static_cast<std::size_t>(tasks), std::cref(task));
  return y;
}

template nn::Var local_normalisation(nn::Tape<float>&, nn::Var, const LocalNormalisationOptions&);
template nn::Var local_normalisation(nn::Tape<double>&, nn::Var, const LocalNormalisationOptions&);

}  // namespace imslam::vo

#include "vo_net/patch_aligner.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::vo {
namespace {

using Lane = Eigen::Array<float, 4, 1>;

constexpr double kPi = 3.14159265358979323846;
constexpr double kOutside = 8.0;  // [px] a patch centre may leave the image by, on the way
constexpr double kMinTexture =
    0.02;                          // [grey^2/px^2] smaller eigenvalue of the mean structure tensor
constexpr double kMinGain = 0.05;  // a patch of less contrast has vanished
constexpr double kCoarsePrecision = 0.03;  // [px] where a finer level follows

bool reachable(const ImagePyramid::Level& level, const Eigen::Vector2d& p) {
  return p.x() > -kOutside && p.y() > -kOutside && p.x() < level.width - 1 + kOutside &&
         p.y() < level.height - 1 + kOutside;
}

bool fully_inside(const ImagePyramid::Level& level, const Eigen::Vector2d& p, int window) {
  const double half = 0.5 * (window - 1);
  return p.x() >= half && p.y() >= half && p.x() <= level.width - 1 - half &&
         p.y() <= level.height - 1 - half;
}

/// Bilinear weights of a position and the integer pixel they start from.
struct Sampler {
  Sampler(const ImagePyramid::Level& level, const Eigen::Vector2d& top_left)
      : x0(static_cast<int>(std::floor(top_left.x()))),
        y0(static_cast<int>(std::floor(top_left.y()))),
        pixels(level.at(x0, y0)),
        stride(level.stride) {
    const auto fx = static_cast<float>(top_left.x() - x0);
    const auto fy = static_cast<float>(top_left.y() - y0);
    w00 = (1.0F - fx) * (1.0F - fy);
    w01 = fx * (1.0F - fy);
    w10 = (1.0F - fx) * fy;
    w11 = fx * fy;
  }

  Lane four(int row, int column) const {
    const float* p = pixels + row * stride + column;
    const float* q = p + stride;
    return w00 * Eigen::Map<const Lane>(p) + w01 * Eigen::Map<const Lane>(p + 1) +
           w10 * Eigen::Map<const Lane>(q) + w11 * Eigen::Map<const Lane>(q + 1);
  }
  int x0;
  int y0;
  const float* pixels;
  int stride;
  float w00, w01, w10, w11;
};

/// How much more the noise of a patch weighs than that of as many independent pixels. Smoothing by
/// a kernel k lowers a pixel's variance by sum k^2 but not that of slow variations, which decide
/// where a patch lies; for a Gaussian 1 / sum k^2 = 4 pi sigma^2. Bilinear interpolation adds 1/6
/// px^2.
double noise_correlation(double smoothing) {
  return std::max(1.0, 4.0 * kPi * (smoothing * smoothing + 1.0 / 6.0));
}

Eigen::Vector2d top_left_of(const Eigen::Vector2d& center, int window) {
  return center - Eigen::Vector2d::Constant(0.5 * (window - 1));
}

}  // namespace

/// Sums of the target patch I, less the template's mean, against the template.
struct PatchTemplate::Sums {
  Eigen::Vector4d against;  ///< [dT/dx, dT/dy, T, 1] . I
  double square = 0.0;      ///< I . I
};

bool PatchTemplate::take(const ImagePyramid::Level& level,
                         const Eigen::Vector2d& center,
                         int window) {
  if (!reachable(level, center)) return false;
  window_ = window;
  lanes_ = (window + 3) / 4 * 4;
  mask_.setZero();
  mask_.head(window).setOnes();
  count_ = static_cast<double>(window) * window;

  // One pixel more on each side, for the differences.
  std::array<std::array<float, kLanes + 8>, kMaxWindow + 2> wide;
  const Sampler sampler(level, top_left_of(center, window + 2));
  Lane sum = Lane::Zero();
  for (int r = 0; r < window + 2; ++r) {
    float* row = wide[static_cast<std::size_t>(r)].data();
    // As far as the differences below read: what the mask multiplies by 0 must be a number.
    for (int c = 0; c < lanes_ + 2; c += 4) Eigen::Map<Lane>(row + c) = sampler.four(r, c);
    if (r == 0 || r > window) continue;
    for (int c = 0; c < lanes_; c += 4) {
      sum += mask_.segment<4>(c) * Eigen::Map<const Lane>(row + c + 1);
    }
  }
  mean_ = static_cast<double>(sum.sum()) / count_;
  const auto mean = static_cast<float>(mean_);
  for (int r = 0; r < window; ++r) {
    const float* above = wide[static_cast<std::size_t>(r)].data();
    const float* here = wide[static_cast<std::size_t>(r) + 1].data();
    const float* below = wide[static_cast<std::size_t>(r) + 2].data();
    for (int c = 0; c < lanes_; c += 4) {
      const Lane mask = mask_.segment<4>(c);
      Eigen::Map<Lane>(&x_(c, r)) =
          0.5F * mask * (Eigen::Map<const Lane>(here + c + 2) - Eigen::Map<const Lane>(here + c));
      Eigen::Map<Lane>(&y_(c, r)) =
          0.5F * mask *
          (Eigen::Map<const Lane>(below + c + 1) - Eigen::Map<const Lane>(above + c + 1));
      Eigen::Map<Lane>(&value_(c, r)) = mask * (Eigen::Map<const Lane>(here + c + 1) - mean);
    }
  }
  return factor_normal_matrix();
}

bool PatchTemplate::factor_normal_matrix() {
  Lane xx = Lane::Zero(), xy = Lane::Zero(), yy = Lane::Zero(), xv = Lane::Zero();
  Lane yv = Lane::Zero(), vv = Lane::Zero(), x1 = Lane::Zero(), y1 = Lane::Zero();
  for (int r = 0; r < window_; ++r) {
    for (int c = 0; c < lanes_; c += 4) {
      const Lane x = Eigen::Map<const Lane>(&x_(c, r));
      const Lane y = Eigen::Map<const Lane>(&y_(c, r));
      const Lane v = Eigen::Map<const Lane>(&value_(c, r));
      xx += x * x;
      xy += x * y;
      yy += y * y;
      xv += x * v;
      yv += y * v;
      vv += v * v;
      x1 += x;
      y1 += y;
    }
  }
  const auto total = [](const Lane& lane) { return static_cast<double>(lane.sum()); };
  Eigen::Matrix4d normal;  // of [dx dy gain offset]; T has no mean left
  normal << total(xx), total(xy), total(xv), total(x1),  //
      total(xy), total(yy), total(yv), total(y1),        //
      total(xv), total(yv), total(vv), 0.0,              //
      total(x1), total(y1), 0.0, count_;
  energy_ = normal(2, 2);
  const Eigen::Matrix2d tensor = normal.topLeftCorner<2, 2>() / count_;
  const double half_trace = 0.5 * tensor.trace();
  const double smaller =
      half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - tensor.determinant()));
  if (!(smaller > kMinTexture)) return false;
  inverse_full_ = normal.inverse();
  Eigen::Matrix3d row_normal;
  row_normal << normal(0, 0), normal(0, 2), normal(0, 3),  //
      normal(2, 0), normal(2, 2), normal(2, 3),            //
      normal(3, 0), normal(3, 2), normal(3, 3);
  inverse_row_ = row_normal.inverse();
  return inverse_full_.allFinite() && inverse_row_.allFinite();
}

PatchTemplate::Sums PatchTemplate::sums_at(const ImagePyramid::Level& level,
                                           const Eigen::Vector2d& position) const {
  const Sampler sampler(level, top_left_of(position, window_));
  const auto mean = static_cast<float>(mean_);
  Lane x = Lane::Zero(), y = Lane::Zero(), v = Lane::Zero(), one = Lane::Zero();
  Lane square = Lane::Zero();
  for (int r = 0; r < window_; ++r) {
    for (int c = 0; c < lanes_; c += 4) {
      const Lane value = mask_.segment<4>(c) * (sampler.four(r, c) - mean);
      x += Eigen::Map<const Lane>(&x_(c, r)) * value;
      y += Eigen::Map<const Lane>(&y_(c, r)) * value;
      v += Eigen::Map<const Lane>(&value_(c, r)) * value;
      one += value;
      square += value * value;
    }
  }
  Sums sums;
  sums.against << static_cast<double>(x.sum()), static_cast<double>(y.sum()),
      static_cast<double>(v.sum()), static_cast<double>(one.sum());
  sums.square = static_cast<double>(square.sum());
  return sums;
}

Alignment PatchTemplate::finish(const Sums& sums,
                                const Eigen::Vector2d& position,
                                double smoothing,
                                bool along_row) const {
  Alignment result;
  result.position = position;
  const double mean_part = sums.against[3] * sums.against[3] / count_;
  const double target_energy = std::max(sums.square - mean_part, 0.0);
  result.correlation = sums.against[2] / std::sqrt(energy_ * target_energy + 1e-9);
  result.gain = sums.against[2] / energy_;
  const double residual =
      std::max(0.0, target_energy - sums.against[2] * sums.against[2] / energy_);
  const double variance = noise_correlation(smoothing) * residual / (count_ - 4.0) /
                          (result.gain * result.gain + 1e-12);
  if (along_row) {
    result.covariance = variance * inverse_row_(0, 0) * Eigen::Matrix2d::Identity();
  } else {
    result.covariance = variance * inverse_full_.topLeftCorner<2, 2>();
  }
  result.found = result.gain > kMinGain && result.covariance.allFinite();
  return result;
}

Alignment PatchTemplate::align(const ImagePyramid::Level& level,
                               const Eigen::Vector2d& start,
                               const AlignOptions& options,
                               bool along_row) const {
  Eigen::Vector2d position = start;
  for (int i = 0; i < options.max_iterations; ++i) {
    if (!reachable(level, position)) return {};
    const Sums sums = sums_at(level, position);
    Eigen::Vector2d scaled = Eigen::Vector2d::Zero();
    double gain = 0.0;
    if (along_row) {
      const Eigen::Vector3d x =
          inverse_row_ * Eigen::Vector3d(sums.against[0], sums.against[2], sums.against[3]);
      scaled.x() = x[0];
      gain = x[1];
    } else {
      const Eigen::Vector4d x = inverse_full_ * sums.against;
      scaled = x.head<2>();
      gain = x[2];
    }
    if (!(gain > kMinGain)) return {};
    Eigen::Vector2d step = -scaled / gain;
    const double length = step.norm();
    if (!std::isfinite(length)) return {};
    if (length > options.max_step) step *= options.max_step / length;
    position += step;
    if (length < options.precision) break;
  }
  if (!reachable(level, position)) return {};
  return finish(sums_at(level, position), position, options.smoothing, along_row);
}

double PatchTemplate::correlation_at(const ImagePyramid::Level& level,
                                     const Eigen::Vector2d& position) const {
  if (!reachable(level, position)) return -1.0;
  return finish(sums_at(level, position), position, 0.0, true).correlation;
}

Alignment align_patch(const ImagePyramid& from,
                      const Eigen::Vector2d& center,
                      const ImagePyramid& to,
                      const Eigen::Vector2d& start,
                      int coarsest_level,
                      const AlignOptions& options,
                      bool along_row) {
  const int last = static_cast<int>(std::min(from.levels().size(), to.levels().size())) - 1;
  Eigen::Vector2d position = start;
  PatchTemplate patch;
  Alignment result;
  for (int level = std::min(coarsest_level, last); level >= 0; --level) {
    const double scale = 1.0 / static_cast<double>(1 << level);
    if (!patch.take(from[level], center * scale, options.window)) {
      if (level == 0) return {};
      continue;  // no texture left at this size: a finer level may have some
    }
    AlignOptions level_options = options;
    if (level > 0) level_options.precision = std::max(options.precision, kCoarsePrecision);
    result = patch.align(to[level], position * scale, level_options, along_row);
    if (!result.found && level == 0) return {};
    if (result.found) position = result.position / scale;
  }
  result.position = position;
  result.found = result.found && fully_inside(to[0], position, options.window);
  return result;
}

}  // namespace imslam::vo

#include "vo_net/patch_aligner.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "slam/base/error.hpp"

namespace imslam::vo {
namespace {

using Lane = Eigen::Array<float, 4, 1>;

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
  float one(int row, int column) const {
    const float* p = pixels + row * stride + column;
    return w00 * p[0] + w01 * p[1] + w10 * p[stride] + w11 * p[stride + 1];
  }

  int x0;
  int y0;
  const float* pixels;
  int stride;
  float w00, w01, w10, w11;
};

Eigen::Vector2d top_left_of(const Eigen::Vector2d& center, int window) {
  return center - Eigen::Vector2d::Constant(0.5 * (window - 1));
}

}  // namespace

/// Weighted sums of the target patch against the template.
struct PatchTemplate::Sums {
  Eigen::Vector4d against;  ///< [w Tx, w Ty, w T, w] . I
  double square = 0.0;      ///< sum w I^2
};

bool PatchTemplate::take(const ImagePyramid::Level& level,
                         const Eigen::Vector2d& center,
                         int window) {
  if (!reachable(level, center)) return false;
  window_ = window;
  lanes_ = (window + 3) / 4 * 4;

  // One pixel more on each side, for the differences.
  std::array<std::array<float, kMaxWindow + 2>, kMaxWindow + 2> value{};
  const Sampler sampler(level, top_left_of(center, window + 2));
  for (int r = 0; r < window + 2; ++r) {
    for (int c = 0; c < window + 2; ++c) value[r][c] = sampler.one(r, c);
  }
  double sum = 0.0;
  for (int r = 1; r <= window; ++r) {
    for (int c = 1; c <= window; ++c) sum += static_cast<double>(value[r][c]);
  }
  weights_ = static_cast<double>(window) * window;
  mean_ = sum / weights_;
  const auto mean = static_cast<float>(mean_);

  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  for (int r = 0; r < window; ++r) {
    for (int c = 0; c < lanes_; ++c) {
      const bool used = c < window;
      const float w = used ? 1.0F : 0.0F;
      const float x = used ? 0.5F * (value[r + 1][c + 2] - value[r + 1][c]) : 0.0F;
      const float y = used ? 0.5F * (value[r + 2][c + 1] - value[r][c + 1]) : 0.0F;
      const float v = used ? value[r + 1][c + 1] - mean : 0.0F;
      weighted_x_(c, r) = w * x;
      weighted_y_(c, r) = w * y;
      weighted_value_(c, r) = w * v;
      weight_(c, r) = w;
      const Eigen::Vector4d row(x, y, v, 1.0);
      if (used) normal.noalias() += static_cast<double>(w) * (row * row.transpose());
    }
  }
  energy_ = normal(2, 2);
  const Eigen::Matrix2d tensor = normal.topLeftCorner<2, 2>() / weights_;
  const double half_trace = 0.5 * tensor.trace();
  const double smaller =
      half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - tensor.determinant()));
  if (!(smaller > kMinTexture)) return false;
  inverse_full_ = normal.inverse();
  Eigen::Matrix3d row_normal;
  row_normal << normal(0, 0), normal(0, 2), normal(0, 3), normal(2, 0), normal(2, 2), normal(2, 3),
      normal(3, 0), normal(3, 2), normal(3, 3);
  inverse_row_ = row_normal.inverse();
  return inverse_full_.allFinite() && inverse_row_.allFinite();
}

PatchTemplate::Sums PatchTemplate::sums_at(const ImagePyramid::Level& level,
                                           const Eigen::Vector2d& position) const {
  const Sampler sampler(level, top_left_of(position, window_));
  const auto mean = static_cast<float>(mean_);
  Lane x = Lane::Zero();
  Lane y = Lane::Zero();
  Lane v = Lane::Zero();
  Lane w = Lane::Zero();
  Lane square = Lane::Zero();
  for (int r = 0; r < window_; ++r) {
    const float* wx = &weighted_x_(0, r);
    const float* wy = &weighted_y_(0, r);
    const float* wv = &weighted_value_(0, r);
    const float* ww = &weight_(0, r);
    for (int c = 0; c < lanes_; c += 4) {
      const Lane value = sampler.four(r, c) - mean;
      const Lane weighted = Eigen::Map<const Lane>(ww + c) * value;
      x += Eigen::Map<const Lane>(wx + c) * value;
      y += Eigen::Map<const Lane>(wy + c) * value;
      v += Eigen::Map<const Lane>(wv + c) * value;
      w += weighted;
      square += weighted * value;
    }
  }
  Sums sums;
  sums.against << static_cast<double>(x.sum()), static_cast<double>(y.sum()),
      static_cast<double>(v.sum()), static_cast<double>(w.sum());
  sums.square = static_cast<double>(square.sum());
  return sums;
}

Alignment PatchTemplate::finish(const Sums& sums,
                                const Eigen::Vector2d& position,
                                bool along_row) const {
  Alignment result;
  result.position = position;
  const double mean_part = sums.against[3] * sums.against[3] / weights_;
  const double target_energy = std::max(sums.square - mean_part, 0.0);
  result.correlation = sums.against[2] / std::sqrt(energy_ * target_energy + 1e-9);
  result.gain = sums.against[2] / energy_;
  const double residual =
      std::max(0.0, target_energy - sums.against[2] * sums.against[2] / energy_);
  const double variance = residual / (weights_ - 4.0) / (result.gain * result.gain + 1e-12);
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
  return finish(sums_at(level, position), position, along_row);
}

double PatchTemplate::correlation_at(const ImagePyramid::Level& level,
                                     const Eigen::Vector2d& position) const {
  if (!reachable(level, position)) return -1.0;
  return finish(sums_at(level, position), position, true).correlation;
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

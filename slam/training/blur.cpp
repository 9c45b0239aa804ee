#include "slam/training/blur.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "datasets/simulation/lanes.hpp"

// Vectors are passed by reference only, so their calling convention does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace imslam::training {
namespace {

using simulation::all;
using simulation::Floats;
using simulation::Ints;
using simulation::kLanes;
using simulation::least;
using simulation::most;
using simulation::to_floats;
using simulation::to_ints;

constexpr float kShortestSmear = 0.25F;  ///< [px] less is not worth a tap

[[gnu::always_inline]] inline Floats bilinear(
    const float* image, int width, int height, const Floats& column, const Floats& row) {
  const Floats x = least(most(column, all(0.0F)), all(static_cast<float>(width - 1)));
  const Floats y = least(most(row, all(0.0F)), all(static_cast<float>(height - 1)));
  Ints x0 = to_ints(x);
  Ints y0 = to_ints(y);
  x0 = x0 < width - 2 ? x0 : Ints{} + (width - 2);
  y0 = y0 < height - 2 ? y0 : Ints{} + (height - 2);
  const Floats fx = x - to_floats(x0);
  const Floats fy = y - to_floats(y0);
  const Ints at = y0 * width + x0;
  Floats upper_left, upper_right, lower_left, lower_right;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float* corner = image + at[i];
    upper_left[i] = corner[0];
    upper_right[i] = corner[1];
    lower_left[i] = corner[width];
    lower_right[i] = corner[width + 1];
  }
  const Floats upper = upper_left + fx * (upper_right - upper_left);
  const Floats lower = lower_left + fx * (lower_right - lower_left);
  return upper + fy * (lower - upper);
}

std::vector<float> gaussian(float sigma) {
  const int reach = std::max(1, static_cast<int>(std::ceil(3.0F * sigma)));
  std::vector<float> weights;
  float sum = 0.0F;
  for (int i = -reach; i <= reach; ++i) {
    const float z = static_cast<float>(i) / sigma;
    weights.push_back(std::exp(-0.5F * z * z));
    sum += weights.back();
  }
  for (float& weight : weights) weight /= sum;
  return weights;
}

}  // namespace

/// Means along the segments of sixteen pixels in a row, beginning at `column`.
IMSLAM_FOR_EACH_PROCESSOR void smear_pixels(const MotionBlur& blur,
                                            const float* image,
                                            int width,
                                            int height,
                                            int row,
                                            int column,
                                            float* result) {
  Floats x;
  for (std::size_t i = 0; i < kLanes; ++i)
    x[i] = static_cast<float>(column) + static_cast<float>(i);
  const Floats place_x = x * (2.0F / static_cast<float>(width - 1)) - 1.0F;
  const float place_y = 2.0F * static_cast<float>(row) / static_cast<float>(height - 1) - 1.0F;
  const Floats u = blur.u + blur.u_x * place_x + blur.u_y * place_y;
  const Floats v = blur.v + blur.v_x * place_x + blur.v_y * place_y;
  float longest_sq = 0.0F;
  for (std::size_t i = 0; i < kLanes; ++i)
    longest_sq = std::max(longest_sq, u[i] * u[i] + v[i] * v[i]);
  const float longest = std::sqrt(longest_sq);
  // Neighbours share the number of taps; longer smears than allowed are scaled down.
  const int taps = longest > kShortestSmear
                       ? std::min(static_cast<int>(std::ceil(longest)), kLongestSmear) + 1
                       : 1;
  const float cut = longest > kLongestSmear ? kLongestSmear / longest : 1.0F;
  Floats sum = {};
  for (int k = 0; k < taps; ++k) {
    const float along = cut * ((static_cast<float>(k) + 0.5F) / static_cast<float>(taps) - 0.5F);
    sum += bilinear(image, width, height, x + along * u,
                    Floats{} + static_cast<float>(row) + along * v);
  }
  const Floats mean = sum / static_cast<float>(taps);
  std::memcpy(result, &mean, sizeof mean);
}

/// result[i] = sum over k of weights[k] from[i + k stride], i < count
IMSLAM_FOR_EACH_PROCESSOR void filter_row(
    const float* from, int stride, const float* weights, int taps, int count, float* result) {
  for (int i = 0; i < count; i += static_cast<int>(kLanes)) {
    Floats sum = {};
    for (int k = 0; k < taps; ++k) {
      Floats values;
      std::memcpy(&values, from + k * stride + i, sizeof values);
      sum += weights[k] * values;
    }
    std::memcpy(result + i, &sum, sizeof sum);
  }
}

void blur_motion(const MotionBlur& blur, int width, int height, std::vector<float>& grey) {
  const std::vector<float> sharp = grey;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; column += static_cast<int>(kLanes)) {
      smear_pixels(blur, sharp.data(), width, height, row, column,
                   grey.data() + row * width + column);
    }
  }
}

void blur_defocus(const DefocusBlur& blur, int width, int height, std::vector<float>& grey) {
  const std::vector<float> weights = gaussian(blur.sigma);
  const int taps = static_cast<int>(weights.size());
  const int reach = taps / 2;
  // Rows into an image with repeated rows above and below, then columns.
  std::vector<float> across(static_cast<std::size_t>(width) *
                            static_cast<std::size_t>(height + 2 * reach));
  std::vector<float> padded(static_cast<std::size_t>(width + 2 * reach));
  for (int row = -reach; row < height + reach; ++row) {
    const float* from = grey.data() + std::clamp(row, 0, height - 1) * width;
    std::fill_n(padded.begin(), reach, from[0]);
    std::copy_n(from, width, padded.begin() + reach);
    std::fill_n(padded.begin() + reach + width, reach, from[width - 1]);
    filter_row(padded.data(), 1, weights.data(), taps, width,
               across.data() + (row + reach) * width);
  }
  std::vector<float> blurred(static_cast<std::size_t>(width));
  for (int row = 0; row < height; ++row) {
    filter_row(across.data() + row * width, width, weights.data(), taps, width, blurred.data());
    const float y = 2.0F * static_cast<float>(row) / static_cast<float>(height - 1) - 1.0F;
    float* to = grey.data() + row * width;
    for (int column = 0; column < width; ++column) {
      const float x = 2.0F * static_cast<float>(column) / static_cast<float>(width - 1) - 1.0F;
      const float share = std::clamp(1.0F + blur.share_x * x + blur.share_y * y, 0.0F, 1.0F);
      to[column] += share * (blurred[static_cast<std::size_t>(column)] - to[column]);
    }
  }
}

}  // namespace imslam::training

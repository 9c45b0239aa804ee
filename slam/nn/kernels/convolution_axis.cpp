#include "slam/nn/kernels/convolution_axis.hpp"

#include <algorithm>
#include <numeric>

namespace imslam::nn::kernels {

AxisTaps ConvolutionAxis::taps(int phase) const {
  if (!backward) return {kernel, 0, 1, -padding, dilation};
  const int period = step / std::gcd(step, dilation);
  for (int k = 0; k < std::min(period, kernel); ++k) {
    const int distance = phase + padding - k * dilation;
    if (distance % step != 0) continue;
    const int count = (kernel - k + period - 1) / period;
    return {count, k, period, distance / step, -(period * dilation / step)};
  }
  return {};
}

int ConvolutionAxis::lowest_offset() const {
  int lowest = 0;
  bool found = false;
  for (int phase = 0; phase < step; ++phase) {
    const AxisTaps axis = taps(phase);
    if (axis.count == 0) continue;
    lowest = found ? std::min(lowest, axis.lowest()) : axis.lowest();
    found = true;
  }
  return lowest;
}

int ConvolutionAxis::highest_offset() const {
  int highest = 0;
  bool found = false;
  for (int phase = 0; phase < step; ++phase) {
    const AxisTaps axis = taps(phase);
    if (axis.count == 0) continue;
    highest = found ? std::max(highest, axis.highest()) : axis.highest();
    found = true;
  }
  return highest;
}

}  // namespace imslam::nn::kernels

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/base/random.hpp"

namespace imslam::training {

/// Outlines of cut-outs: blobs, polygons, boxes, leaves, fences, poles, frames. Each is a square of
/// 8-bit samples over pattern coordinates |s|, |t| <= 1.
///
///   (s, t) is inside  <=>  |s| < 1, |t| < 1 and bilinear(samples, s, t) >= kEdge
class ShapeBank {
 public:
  static constexpr int kSize = 128;
  static constexpr float kEdge = 128.0F;

  ShapeBank(std::size_t count, const Random& random);

  std::size_t size() const { return samples_.size() / (kSize * kSize); }
  /// Row major, kSize * kSize; the first sample lies at s = t = -1, the last at s = t = 1.
  const std::uint8_t* samples(std::size_t shape) const {
    return samples_.data() + shape * (kSize * kSize);
  }
  bool inside(std::size_t shape, double s, double t) const;

 private:
  std::vector<std::uint8_t> samples_;
};

}  // namespace imslam::training

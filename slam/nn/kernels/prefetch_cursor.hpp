#pragma once

#include <algorithm>
#include <cstddef>

namespace imslam::nn::kernels {

/// Deals out the memory of a rectangle of an image, row by row, in portions of cache lines: what
/// the next strip will read is asked for little by little while this one is computed.
class PrefetchCursor {
 public:
  struct Portion {
    const float* begin = nullptr;
    const float* end = nullptr;
  };

  PrefetchCursor() = default;
  PrefetchCursor(const float* first, std::ptrdiff_t row_floats, std::ptrdiff_t row_pitch, int rows)
      : row_(first), row_floats_(row_floats), row_pitch_(row_pitch), rows_(rows) {}

  bool empty() const { return rows_ == 0; }

  Portion next(int lines) {
    constexpr std::ptrdiff_t kLineFloats = 16;
    Portion portion;
    portion.begin = row_ + done_;
    done_ = std::min(row_floats_, done_ + lines * kLineFloats);
    portion.end = row_ + done_;
    if (done_ == row_floats_) {
      row_ += row_pitch_;
      done_ = 0;
      --rows_;
    }
    return portion;
  }

 private:
  const float* row_ = nullptr;
  std::ptrdiff_t row_floats_ = 0, row_pitch_ = 0, done_ = 0;
  int rows_ = 0;
};

}  // namespace imslam::nn::kernels

#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

namespace imslam::bench {

/// Numbers per pixel as they stand in a file, row by row.
template <typename T, std::size_t N>
struct TruthImage {
  int width = 0, height = 0;
  std::vector<std::array<T, N>> pixels;

  const std::array<T, N>& at(int row, int column) const {
    return pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(column)];
  }
};

// PNG files, channels in OpenCV's order (blue, green, red, alpha). InputError if a file is missing
// or of another type.

/// 4 x 8 bit whose bytes are one float32.
TruthImage<float, 1> read_float_png(const std::filesystem::path& file);
TruthImage<std::uint16_t, 3> read_uint16x3_png(const std::filesystem::path& file);
TruthImage<std::uint16_t, 1> read_uint16_png(const std::filesystem::path& file);

/// (value - 32768) / 64 px, the coding of TartanAir's flow.
inline float decoded_flow(std::uint16_t value) {
  return (static_cast<float>(value) - 32768.0F) / 64.0F;
}

/// Middlebury's .flo: "PIEH", width, height, float32 (u, v) per pixel.
TruthImage<float, 2> read_flo(const std::filesystem::path& file);

}  // namespace imslam::bench

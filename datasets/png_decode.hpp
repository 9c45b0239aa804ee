#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "datasets/image_io.hpp"

namespace imslam::datasets {

bool is_png(const std::uint8_t* bytes, std::size_t size);

/// From the IHDR chunk; empty if the file is too short for one or the numbers are impossible.
std::optional<ImageSize> png_size(const std::uint8_t* bytes, std::size_t size);

/// Decodes to 8-bit grey. `image` must have the size that png_size() gave.
/// Returns the fault, or an empty string.
std::string decode_png(const std::uint8_t* bytes, std::size_t size, GrayImage& image);

}  // namespace imslam::datasets

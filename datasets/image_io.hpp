#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slam/sensors/stereo.hpp"

namespace imslam::datasets {

struct ImageSize {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  bool operator==(const ImageSize& other) const {
    return width == other.width && height == other.height;
  }
};

/// Images above this are refused before memory is taken for them.
inline constexpr std::int64_t kMaxImagePixels = 64'000'000;

/// Either an image or the reason why there is none ("missing", "truncated", ...).
struct DecodedImage {
  GrayImage image;
  std::string fault;
};

/// Decodes PNG and JPEG files to 8-bit grey; 16-bit images keep their upper byte, colour becomes
/// luminance. Never throws on bad content: the fault says what is wrong, including truncated JPEGs
/// (which decoders deliver half grey) and images of another size than `expected`.
/// One object per thread: it keeps the file buffer.
class ImageDecoder {
 public:
  DecodedImage decode(const std::filesystem::path& file, const std::optional<ImageSize>& expected);

 private:
  std::vector<std::uint8_t> bytes_;
};

/// The size as the file's header states it; empty if it is not a PNG or JPEG image.
std::optional<ImageSize> probe_image_size(const std::filesystem::path& file);

}  // namespace imslam::datasets

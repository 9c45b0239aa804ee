#include "datasets/image_io.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "datasets/png_decode.hpp"

namespace imslam::datasets {
namespace {

constexpr std::size_t kMaxFileBytes = 256U << 20U;
constexpr std::size_t kProbeBytes = 1U << 16U;

/// Reads up to `limit` bytes; the fault, or an empty string.
std::string read_bytes(const std::filesystem::path& file,
                       std::size_t limit,
                       std::vector<std::uint8_t>& bytes) {
  bytes.clear();
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return errno == ENOENT ? "missing" : "cannot be opened";
  struct stat status {};
  std::string fault;
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    fault = "not a regular file";
  } else if (status.st_size == 0) {
    fault = "empty file";
  } else if (static_cast<std::size_t>(status.st_size) > kMaxFileBytes) {
    fault = "file too large";
  } else {
    bytes.resize(std::min(limit, static_cast<std::size_t>(status.st_size)));
    std::size_t filled = 0;
    while (filled < bytes.size()) {
      const ssize_t count = ::read(descriptor, bytes.data() + filled, bytes.size() - filled);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) break;
      filled += static_cast<std::size_t>(count);
    }
    if (filled < bytes.size()) fault = "reading failed";
  }
  ::close(descriptor);
  return fault;
}

bool is_jpeg(const std::vector<std::uint8_t>& bytes) {
  return bytes.size() >= 4 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

bool is_start_of_frame(std::uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

/// Walks the marker segments up to the start of frame, which holds the size.
std::optional<ImageSize> jpeg_size(const std::vector<std::uint8_t>& bytes) {
  std::size_t at = 2;
  while (at + 9 < bytes.size() && bytes[at] == 0xFF) {
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    const auto word = [&](std::size_t i) { return bytes[i] * 256 + bytes[i + 1]; };
    if (is_start_of_frame(marker)) {
      const ImageSize size{word(at + 7), word(at + 5)};
      return size.width > 0 && size.height > 0 ? std::optional(size) : std::nullopt;
    }
    at += 2 + static_cast<std::size_t>(word(at + 2));
  }
  return std::nullopt;
}

/// Decoders fill the rest of a truncated JPEG with grey: only the end marker tells.
bool jpeg_is_complete(const std::vector<std::uint8_t>& bytes) {
  std::size_t end = bytes.size();
  while (end > 2 && (bytes[end - 1] == 0 || bytes[end - 1] == '\n')) --end;  // padding
  return bytes[end - 2] == 0xFF && bytes[end - 1] == 0xD9;
}

std::string decode_jpeg(const std::vector<std::uint8_t>& bytes, GrayImage& image) {
  if (!jpeg_is_complete(bytes)) return "truncated JPEG (no end marker)";
  cv::Mat target(image.height, image.width, CV_8UC1, image.pixels.data());
  cv::Mat decoded;
  try {
    decoded = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return "damaged JPEG";
  }
  if (decoded.size() != target.size() || decoded.type() != CV_8UC1) return "damaged JPEG";
  decoded.copyTo(target);
  return {};
}

std::optional<ImageSize> size_in_header(const std::vector<std::uint8_t>& bytes) {
  if (is_png(bytes.data(), bytes.size())) return png_size(bytes.data(), bytes.size());
  return is_jpeg(bytes) ? jpeg_size(bytes) : std::nullopt;
}

}  // namespace

DecodedImage ImageDecoder::decode(const std::filesystem::path& file,
                                  const std::optional<ImageSize>& expected) {
  DecodedImage result;
  result.fault = read_bytes(file, kMaxFileBytes, bytes_);
  if (!result.fault.empty()) return result;
  const auto size = size_in_header(bytes_);
  if (!size) {
    result.fault = "neither a PNG nor a JPEG image";
  } else if (expected && !(*size == *expected)) {
    result.fault = fmt::format("is {}x{} px, expected {}x{}", size->width, size->height,
                               expected->width, expected->height);
  } else if (std::int64_t{size->width} * size->height > kMaxImagePixels) {
    result.fault = fmt::format("is {}x{} px, too large", size->width, size->height);
  }
  if (!result.fault.empty()) return result;
  GrayImage& image = result.image;
  image.width = size->width;
  image.height = size->height;
  image.pixels.resize(static_cast<std::size_t>(size->width) *
                      static_cast<std::size_t>(size->height));
  result.fault = is_jpeg(bytes_) ? decode_jpeg(bytes_, image)
                                 : decode_png(bytes_.data(), bytes_.size(), image);
  if (!result.fault.empty()) image = GrayImage();
  return result;
}

std::optional<ImageSize> probe_image_size(const std::filesystem::path& file) {
  std::vector<std::uint8_t> bytes;
  if (!read_bytes(file, kProbeBytes, bytes).empty()) return std::nullopt;
  return size_in_header(bytes);
}

}  // namespace imslam::datasets

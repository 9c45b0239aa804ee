#include "datasets/png_decode.hpp"

#include <png.h>

#include <csetjmp>
#include <cstring>

namespace imslam::datasets {
namespace {

constexpr std::size_t kHeaderBytes = 8 + 8 + 13;  // signature, chunk head, IHDR

struct Source {
  const std::uint8_t* bytes = nullptr;
  std::size_t left = 0;
  char message[80] = {};
};

std::uint32_t big_endian(const std::uint8_t* bytes) {
  return (std::uint32_t{bytes[0]} << 24U) | (std::uint32_t{bytes[1]} << 16U) |
         (std::uint32_t{bytes[2]} << 8U) | std::uint32_t{bytes[3]};
}

void read_bytes(png_structp png, png_bytep target, png_size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (count > source->left) png_error(png, "file ends early");
  std::memcpy(target, source->bytes, count);
  source->bytes += count;
  source->left -= count;
}

void on_error(png_structp png, png_const_charp message) {
  auto* source = static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source->message, message, sizeof(source->message) - 1);
  png_longjmp(png, 1);
}

void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}

/// Whatever the file holds, rows come out as 8-bit grey.
void ask_for_gray8(png_structp png, png_infop info) {
  const int color = png_get_color_type(png, info);
  const int depth = png_get_bit_depth(png, info);
  if (depth == 16) png_set_strip_16(png);
  if (color == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (color == PNG_COLOR_TYPE_GRAY && depth < 8) png_set_expand_gray_1_2_4_to_8(png);
  // A palette may say which of its colours are transparent.
  const bool transparent = png_get_valid(png, info, PNG_INFO_tRNS) != 0;
  if ((color & PNG_COLOR_MASK_ALPHA) != 0 || transparent) png_set_strip_alpha(png);
  if ((color & PNG_COLOR_MASK_COLOR) != 0) {
    png_set_rgb_to_gray(png, PNG_ERROR_ACTION_NONE, 0.299, 0.587);  // ITU-R BT.601
  }
}

/// Only plain data lives in this frame: libpng leaves it by longjmp on errors.
bool run_decoder(png_structp png, png_infop info, png_bytep* rows, int width, int height) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_user_limits(png, 1U << 20U, 1U << 20U);
  png_read_info(png, info);
  ask_for_gray8(png, info);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != static_cast<std::size_t>(width) ||
      png_get_image_height(png, info) != static_cast<std::uint32_t>(height)) {
    png_error(png, "unexpected row size");
  }
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

}  // namespace

bool is_png(const std::uint8_t* bytes, std::size_t size) {
  return size >= 8 && png_sig_cmp(bytes, 0, 8) == 0;
}

std::optional<ImageSize> png_size(const std::uint8_t* bytes, std::size_t size) {
  if (size < kHeaderBytes || std::memcmp(bytes + 12, "IHDR", 4) != 0) return std::nullopt;
  const std::uint32_t width = big_endian(bytes + 16);
  const std::uint32_t height = big_endian(bytes + 20);
  constexpr std::uint32_t kMaxSide = 1U << 20U;
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide) return std::nullopt;
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

std::string decode_png(const std::uint8_t* bytes, std::size_t size, GrayImage& image) {
  Source source;
  source.bytes = bytes;
  source.left = size;
  std::vector<png_bytep> rows(static_cast<std::size_t>(image.height));
  for (std::size_t row = 0; row < rows.size(); ++row) {
    rows[row] = image.pixels.data() + row * static_cast<std::size_t>(image.width);
  }
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, &on_error, &on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  bool decoded = false;
  if (info != nullptr) {
    png_set_read_fn(png, &source, &read_bytes);
    decoded = run_decoder(png, info, rows.data(), image.width, image.height);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  if (decoded) return {};
  return std::string("damaged PNG (") + (source.message[0] != '\0' ? source.message : "no memory") +
         ")";
}

}  // namespace imslam::datasets

#include "datasets/image_io.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "datasets/png_decode.hpp"
#include "slam/base/random.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/tiny_dataset.hpp"

namespace imslam::datasets {
namespace {

using imslam::testing::TempDir;
using imslam::testing::TinyWorld;

constexpr ImageSize kSize{320, 240};

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::filesystem::path write(const TempDir& dir, const std::string& name, const cv::Mat& image) {
  cv::imwrite((dir.path() / name).string(), image);
  return dir.path() / name;
}

cv::Mat as_mat(const GrayImage& image) {
  return cv::Mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()))
      .clone();
}

double largest_difference(const GrayImage& image, const cv::Mat& expected) {
  return cv::norm(as_mat(image), expected, cv::NORM_INF);
}

TEST(ImageDecoder, ReadsEveryKindOfPngAsTheSameGrey) {
  const TempDir dir;
  const cv::Mat grey = TinyWorld().left(0);
  cv::Mat deep;
  grey.convertTo(deep, CV_16U, 256.0, 77.0);
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  cv::Mat with_alpha;
  cv::cvtColor(grey, with_alpha, cv::COLOR_GRAY2BGRA);
  cv::Mat deep_colour;
  cv::cvtColor(deep, deep_colour, cv::COLOR_GRAY2BGR);
  ImageDecoder decoder;
  for (const cv::Mat& image : {grey, deep, colour, with_alpha, deep_colour}) {
    const DecodedImage decoded = decoder.decode(write(dir, "a.png", image), kSize);
    ASSERT_EQ(decoded.fault, "") << image.type();
    EXPECT_LE(largest_difference(decoded.image, grey), image.channels() == 1 ? 0 : 1)
        << image.type();
  }
}

TEST(ImageDecoder, ReadsAPaletteWithTransparentColours) {
  // 4x1 pixels of the colours 3, 0, 1, 2 of the greys 0, 85, 170, 255; tRNS: 0, 128.
  constexpr std::uint8_t kPng[] = {
      0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A, 0x00, 0x00, 0x00, 0x0D, 0x49, 0x48,
      0x44, 0x52, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00, 0x01, 0x08, 0x03, 0x00, 0x00,
      0x00, 0xCE, 0xE2, 0xFF, 0xFF, 0x00, 0x00, 0x00, 0x0C, 0x50, 0x4C, 0x54, 0x45, 0x00,
      0x00, 0x00, 0x55, 0x55, 0x55, 0xAA, 0xAA, 0xAA, 0xFF, 0xFF, 0xFF, 0xC1, 0x7F, 0x62,
      0xD1, 0x00, 0x00, 0x00, 0x02, 0x74, 0x52, 0x4E, 0x53, 0x00, 0x80, 0x9B, 0x2B, 0x4E,
      0x18, 0x00, 0x00, 0x00, 0x0D, 0x49, 0x44, 0x41, 0x54, 0x78, 0xDA, 0x63, 0x60, 0x66,
      0x60, 0x64, 0x02, 0x00, 0x00, 0x15, 0x00, 0x07, 0x45, 0x70, 0xAD, 0x87, 0x00, 0x00,
      0x00, 0x00, 0x49, 0x45, 0x4E, 0x44, 0xAE, 0x42, 0x60, 0x82};
  const TempDir dir;
  const auto file = dir.write("a.png", std::string(std::begin(kPng), std::end(kPng)));
  const DecodedImage decoded = ImageDecoder().decode(file, ImageSize{4, 1});
  ASSERT_EQ(decoded.fault, "");
  EXPECT_EQ(std::vector<int>(decoded.image.pixels.begin(), decoded.image.pixels.end()),
            (std::vector<int>{255, 0, 85, 170}));
}

TEST(ImageDecoder, ReadsJpegs) {
  const TempDir dir;
  const cv::Mat grey = TinyWorld().left(0);
  const DecodedImage decoded = ImageDecoder().decode(write(dir, "a.jpg", grey), kSize);
  ASSERT_EQ(decoded.fault, "");
  EXPECT_LT(cv::norm(as_mat(decoded.image), grey, cv::NORM_L1) / (320 * 240), 3.0);
}

TEST(ImageDecoder, NamesWhatIsWrong) {
  const TempDir dir;
  const cv::Mat grey = TinyWorld().left(0);
  ImageDecoder decoder;
  const auto fault = [&](const std::filesystem::path& file) {
    const DecodedImage decoded = decoder.decode(file, kSize);
    EXPECT_TRUE(decoded.image.empty());
    return decoded.fault;
  };
  EXPECT_EQ(fault(dir.path() / "none.png"), "missing");
  EXPECT_EQ(fault(dir.write("empty.png", "")), "empty file");
  EXPECT_EQ(fault(dir.write("text.png", "hello, I am a text")), "neither a PNG nor a JPEG image");
  EXPECT_EQ(fault("/dev/zero"), "not a regular file");
  EXPECT_EQ(fault(dir.path()), "not a regular file");
  EXPECT_EQ(fault(write(dir, "small.png", grey(cv::Rect(0, 0, 100, 50)))),
            "is 100x50 px, expected 320x240");
  EXPECT_EQ(fault(write(dir, "small.jpg", grey(cv::Rect(0, 0, 100, 50)))),
            "is 100x50 px, expected 320x240");
}

TEST(ImageDecoder, RefusesAHugeSizeBeforeTakingMemory) {
  const TempDir dir;
  std::string bytes = bytes_of(write(dir, "a.png", TinyWorld().left(0)));
  bytes.replace(16, 8, std::string("\0\x0f\0\0\0\x0f\0\0", 8));  // 983040 x 983040
  const DecodedImage decoded = ImageDecoder().decode(dir.write("b.png", bytes), std::nullopt);
  EXPECT_NE(decoded.fault.find("too large"), std::string::npos) << decoded.fault;
}

TEST(ImageDecoder, DetectsEveryTruncatedImage) {
  const TempDir dir;
  const cv::Mat grey = TinyWorld().left(0);
  ImageDecoder decoder;
  for (const std::string name : {"a.png", "a.jpg"}) {
    const std::string bytes = bytes_of(write(dir, name, grey));
    for (int sixteenths = 1; sixteenths < 16; ++sixteenths) {
      const auto size = bytes.size() * static_cast<std::size_t>(sixteenths) / 16;
      const DecodedImage decoded = decoder.decode(dir.write(name, bytes.substr(0, size)), kSize);
      EXPECT_NE(decoded.fault, "") << name << " cut at " << sixteenths << "/16";
      EXPECT_TRUE(decoded.image.empty());
    }
  }
}

TEST(ImageDecoder, DetectsFlippedBitsInPngs) {
  const TempDir dir;
  const cv::Mat grey = TinyWorld().left(0);
  const std::string bytes = bytes_of(write(dir, "a.png", grey));
  Random random(3);
  ImageDecoder decoder;
  int undetected = 0;
  for (int i = 0; i < 300; ++i) {
    std::string mutant = bytes;
    const auto at =
        static_cast<std::size_t>(random.integer(8, static_cast<std::int64_t>(bytes.size()) - 1));
    mutant[at] = static_cast<char>(mutant[at] ^ (1 << random.integer(0, 7)));
    const DecodedImage decoded = decoder.decode(dir.write("m.png", mutant), kSize);
    // Chunks carry check sums; only the end chunk's own bytes and ancillary data may slip through,
    // and then the pixels are right.
    if (decoded.fault.empty()) {
      ++undetected;
      EXPECT_EQ(largest_difference(decoded.image, grey), 0.0) << "byte " << at;
    }
  }
  EXPECT_LT(undetected, 15);
}

TEST(ProbeImageSize, ReadsTheHeaderOnly) {
  const TempDir dir;
  const cv::Mat grey = TinyWorld().left(0);
  EXPECT_EQ(probe_image_size(write(dir, "a.png", grey)), kSize);
  EXPECT_EQ(probe_image_size(write(dir, "a.jpg", grey)), kSize);
  const std::string head = bytes_of(dir.path() / "a.png").substr(0, 40);
  EXPECT_EQ(probe_image_size(dir.write("head.png", head)), kSize);
  EXPECT_EQ(probe_image_size(dir.write("text.png", "no image")), std::nullopt);
}

TEST(PngSize, RefusesImpossibleNumbers) {
  std::string bytes("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\0\0\0\0\x10\x08\0\0\0\0", 29);
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  EXPECT_EQ(png_size(data, bytes.size()), std::nullopt);
  EXPECT_EQ(png_size(data, 20), std::nullopt);
}

}  // namespace
}  // namespace imslam::datasets

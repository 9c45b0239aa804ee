#include "tools/bench/matching/truth_files.hpp"

#include <cstring>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "slam/base/error.hpp"

namespace imslam::bench {
namespace {

constexpr int kMostPixelsPerSide = 20000;

template <typename T, std::size_t N>
TruthImage<T, N> read_png(const std::filesystem::path& file, int type, const char* expected) {
  const cv::Mat image = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  if (image.empty() || image.type() != type) {
    throw InputError(file.string() + ": expected a PNG of " + expected);
  }
  TruthImage<T, N> truth{image.cols, image.rows, {}};
  truth.pixels.resize(image.total());
  for (int row = 0; row < image.rows; ++row) {
    std::memcpy(truth.pixels.data() + static_cast<std::ptrdiff_t>(row) * image.cols, image.ptr(row),
                static_cast<std::size_t>(image.cols) * image.elemSize());
  }
  return truth;
}

}  // namespace

TruthImage<float, 1> read_float_png(const std::filesystem::path& file) {
  return read_png<float, 1>(file, CV_8UC4, "4 x 8 bit");
}

TruthImage<std::uint16_t, 3> read_uint16x3_png(const std::filesystem::path& file) {
  return read_png<std::uint16_t, 3>(file, CV_16UC3, "3 x 16 bit");
}

TruthImage<std::uint16_t, 1> read_uint16_png(const std::filesystem::path& file) {
  return read_png<std::uint16_t, 1>(file, CV_16UC1, "16 bit grey");
}

TruthImage<float, 2> read_flo(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 4> tag{};
  std::array<std::int32_t, 2> size{};
  stream.read(tag.data(), tag.size());
  stream.read(reinterpret_cast<char*>(size.data()), sizeof size);
  const auto fits = [](std::int32_t side) { return side > 0 && side <= kMostPixelsPerSide; };
  if (!stream || std::memcmp(tag.data(), "PIEH", 4) != 0 || !fits(size[0]) || !fits(size[1])) {
    throw InputError(file.string() + ": expected a .flo file that begins with PIEH and its size");
  }
  TruthImage<float, 2> truth{size[0], size[1], {}};
  truth.pixels.resize(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]));
  const std::size_t bytes = truth.pixels.size() * sizeof truth.pixels[0];
  stream.read(reinterpret_cast<char*>(truth.pixels.data()), static_cast<std::streamsize>(bytes));
  if (!stream) throw InputError(file.string() + ": ends before its last pixel");
  return truth;
}

}  // namespace imslam::bench

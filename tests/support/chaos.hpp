#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "tests/support/chaos_tables.hpp"

namespace imslam::testing {

/// Spoils a copy of a EuRoC folder in the ways recordings go wrong: tables, images, calibration.
class Chaos : public ChaosTables {
 public:
  using ChaosTables::ChaosTables;

  enum class Side { kLeft, kRight, kBoth };
  using Pixels = std::function<void(cv::Mat&, Random&)>;
  using FramePixels = std::function<void(cv::Mat&, int frame, Random&)>;

  // Images -------------------------------------------------------------------------------------

  void drop_images(Side side, double share) {
    for_images(side, [&](const auto& file) {
      if (random_.chance(share)) std::filesystem::remove(file);
    });
  }

  void drop_images(Side side, Span span) {
    for_images(side, span, [](const auto& file) { std::filesystem::remove(file); });
  }

  /// Ends the files at a random place: from nothing left to all but a byte.
  void truncate_images(Side side, double share) {
    change_bytes(side, share, [this](std::string& bytes) {
      bytes.resize(static_cast<std::size_t>(random_.integer(0, last_index(bytes))));
    });
  }

  void flip_bits(Side side, double share, int bits) {
    change_bytes(side, share, [this, bits](std::string& bytes) {
      for (int i = 0; i < bits; ++i) {
        const auto at = static_cast<std::size_t>(random_.integer(0, last_index(bytes)));
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random_.integer(0, 7)));
      }
    });
  }

  void replace_images(Side side, double share, const std::string& content) {
    change_bytes(side, share, [&](std::string& bytes) { bytes = content; });
  }

  /// `pixels` changes the decoded image in place, or puts another one there.
  void paint(Side side, Span span, const Pixels& pixels) {
    paint_frames(side, span, [&](cv::Mat& image, int, Random& random) { pixels(image, random); });
  }

  /// Likewise, told the number of the frame within the span.
  void paint_frames(Side side, Span span, const FramePixels& pixels) {
    for (const Side one : {Side::kLeft, Side::kRight}) {
      if (side != one && side != Side::kBoth) continue;
      int frame = 0;
      for_images(one, span, [&](const auto& file) {
        cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
        pixels(image, frame++, random_);
        std::filesystem::remove(file);
        cv::imwrite(file.string(), image, {cv::IMWRITE_PNG_COMPRESSION, 1});
      });
    }
  }

  /// The images within `span` are shown in reverse; stamps and IMU go on forwards.
  void reverse_images(Span span) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      std::vector<std::filesystem::path> files;
      for_images(side, span, [&](const auto& file) { files.push_back(file); });
      const auto spare = mav0() / "spare";
      for (std::size_t i = 0, k = files.size(); i + 1 < k; ++i, --k) {
        std::filesystem::rename(files[i], spare);
        std::filesystem::rename(files[k - 1], files[i]);
        std::filesystem::rename(spare, files[k - 1]);
      }
    }
  }

  /// The images change places, calibration and index stay.
  void exchange_images() {
    const auto spare = mav0() / "spare";
    std::filesystem::rename(mav0() / "cam0" / "data", spare);
    std::filesystem::rename(mav0() / "cam1" / "data", mav0() / "cam0" / "data");
    std::filesystem::rename(spare, mav0() / "cam1" / "data");
  }

  /// From `at_s` on, images, IMU and truth are those of another recording by the same rig.
  void follow_with(const Chaos& other, double at_s) {
    namespace fs = std::filesystem;
    const std::int64_t shift_ns =
        start_ns_ + static_cast<std::int64_t>(at_s * 1e9) - other.start_ns_;
    for (const char* name : {"cam0", "cam1", "imu0", "state_groundtruth_estimate0"}) {
      const fs::path csv = mav0() / name / "data.csv";
      cut_lines(csv, {at_s, 1e9});
      const Lines foreign = read_lines(other.mav0() / name / "data.csv");
      edit(csv, [&](Lines& lines) {
        for (std::size_t i = 1; i < foreign.size(); ++i) {
          if (stamp(foreign[i]) < other.start_ns_) continue;
          const auto rest = foreign[i].substr(foreign[i].find(','));
          const std::string time = std::to_string(stamp(foreign[i]) + shift_ns);
          const fs::path image = other.mav0() / name / "data" / rest.substr(1);
          const bool is_image = name[0] == 'c';
          const std::string cell = is_image ? ",other_" + time + ".png" : rest;
          if (is_image) fs::copy_symlink(image, mav0() / name / "data" / cell.substr(1));
          lines.push_back(time + cell);
        }
      });
    }
  }

  // Calibration --------------------------------------------------------------------------------

  std::filesystem::path sensor_file(int camera) const {
    return mav0() / ("cam" + std::to_string(camera)) / "sensor.yaml";
  }

  /// Replaces what stands between `begin` and `end`; fails where it is not found.
  static void replace_between(const std::filesystem::path& file,
                              const std::string& begin,
                              const std::string& end,
                              const std::function<std::string(const std::string&)>& change) {
    std::string text = read(file);
    const auto first = text.find(begin);
    if (first == std::string::npos) throw std::runtime_error(file.string() + ": no " + begin);
    const auto from = first + begin.size();
    const auto to = text.find(end, from);
    write(file, text.replace(from, to - from, change(text.substr(from, to - from))));
  }

  /// `change` gets the 16 numbers of T_BS, row by row.
  void edit_extrinsics(int camera, const std::function<void(std::array<double, 16>&)>& change) {
    replace_between(sensor_file(camera), "data: [", "]", [&](const std::string& text) {
      std::array<double, 16> matrix = {};
      const auto cells = split(text, ',');
      for (std::size_t i = 0; i < 16; ++i) matrix.at(i) = std::stod(std::string(cells.at(i)));
      change(matrix);
      std::string changed;
      for (const double value : matrix) {
        char cell[40];
        std::snprintf(cell, sizeof(cell), "%s%.17g", changed.empty() ? "" : ", ", value);
        changed += cell;
      }
      return changed;
    });
  }

  void invert_extrinsics(int camera) {
    edit_extrinsics(camera, [](std::array<double, 16>& T) {
      const auto old = T;
      for (std::size_t row = 0; row < 3; ++row) {
        T.at(4 * row + 3) = 0.0;
        for (std::size_t column = 0; column < 3; ++column) {
          T.at(4 * row + column) = old.at(4 * column + row);
          T.at(4 * row + 3) -= old.at(4 * column + row) * old.at(4 * column + 3);
        }
      }
    });
  }

  /// Moves the right camera along the line between the two.
  void scale_baseline(double factor) {
    std::array<double, 16> left = {};
    edit_extrinsics(0, [&](std::array<double, 16>& T) { left = T; });
    edit_extrinsics(1, [&](std::array<double, 16>& T) {
      for (const std::size_t i : {3U, 7U, 11U})
        T.at(i) = left.at(i) + factor * (T.at(i) - left.at(i));
    });
  }

 private:
  void change_bytes(Side side, double share, const std::function<void(std::string&)>& change) {
    for_images(side, [&](const auto& file) {
      if (!random_.chance(share)) return;
      std::string bytes = read(file);
      change(bytes);
      write(file, bytes);
    });
  }

  /// Calls `act` with the image files within `span` in the order of their stamps.
  template <typename Act>
  void for_images(Side side, Span span, Act&& act) {
    for (const int camera : {0, 1}) {
      if ((side == Side::kLeft && camera == 1) || (side == Side::kRight && camera == 0)) continue;
      const auto home = mav0() / ("cam" + std::to_string(camera));
      const Lines lines = read_lines(home / "data.csv");
      for (std::size_t i = 1; i < lines.size(); ++i) {
        if (inside(span, lines[i])) act(home / "data" / lines[i].substr(lines[i].find(',') + 1));
      }
    }
  }
  template <typename Act>
  void for_images(Side side, Act&& act) {
    for_images(side, everything(), act);
  }
};

}  // namespace imslam::testing

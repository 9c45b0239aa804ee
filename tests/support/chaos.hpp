#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/base/text.hpp"

namespace imslam::testing {

/// Spoils a copy of a EuRoC folder in the ways recordings go wrong. The same seed and calls always
/// make the same damage. Text files are copies, unchanged images links: making one takes
/// milliseconds. Times are seconds since the first left image; intervals are half open.
class Chaos {
 public:
  enum class Side { kLeft, kRight, kBoth };
  struct Span {
    double from_s;
    double to_s;
  };
  using Lines = std::vector<std::string>;
  using Reading = std::array<std::string, 6>;  ///< gyro [rad/s], accelerometer [m/s^2] as text
  using Pixels = std::function<void(cv::Mat&, Random&)>;

  Chaos(const std::filesystem::path& base, std::filesystem::path folder, std::uint64_t seed = 1)
      : folder_(std::move(folder)), random_(seed) {
    namespace fs = std::filesystem;
    fs::create_directories(folder_);
    for (const auto& entry : fs::recursive_directory_iterator(fs::absolute(base))) {
      const fs::path copy = folder_ / fs::relative(entry.path(), base);
      if (entry.is_directory()) {
        fs::create_directories(copy);
      } else if (entry.path().extension() == ".png") {
        fs::create_symlink(entry.path(), copy);
      } else {
        fs::copy_file(entry.path(), copy);
      }
    }
    start_ns_ = stamp(read_lines(left_csv()).at(1));
  }

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path mav0() const { return folder_ / "mav0"; }
  std::filesystem::path left_csv() const { return mav0() / "cam0" / "data.csv"; }
  std::filesystem::path right_csv() const { return mav0() / "cam1" / "data.csv"; }
  std::filesystem::path imu_csv() const { return mav0() / "imu0" / "data.csv"; }

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

  /// `pixels` changes the decoded image in place.
  void paint(Side side, Span span, const Pixels& pixels) {
    for_images(side, span, [&](const auto& file) {
      cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
      pixels(image, random_);
      std::filesystem::remove(file);
      cv::imwrite(file.string(), image, {cv::IMWRITE_PNG_COMPRESSION, 1});
    });
  }

  /// The images change places, calibration and index stay.
  void exchange_images() {
    const auto spare = mav0() / "spare";
    std::filesystem::rename(mav0() / "cam0" / "data", spare);
    std::filesystem::rename(mav0() / "cam1" / "data", mav0() / "cam0" / "data");
    std::filesystem::rename(spare, mav0() / "cam1" / "data");
  }

  // Tables -------------------------------------------------------------------------------------

  /// `change` gets the lines below the header.
  static void edit(const std::filesystem::path& csv, const std::function<void(Lines&)>& change) {
    Lines lines = read_lines(csv);
    const std::string header = lines.at(0);
    lines.erase(lines.begin());
    change(lines);
    std::string text = header + "\n";
    for (const std::string& line : lines) text += line + "\n";
    write(csv, text);
  }

  void swap_neighbours(const std::filesystem::path& csv, int count) {
    edit(csv, [&](Lines& lines) {
      for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::size_t>(random_.integer(0, last_index(lines) - 1));
        std::swap(lines[at], lines[at + 1]);
      }
    });
  }

  void repeat_lines(const std::filesystem::path& csv, double share) {
    edit(csv, [&](Lines& lines) {
      Lines repeated;
      for (const std::string& line : lines) {
        repeated.insert(repeated.end(), random_.chance(share) ? 2 : 1, line);
      }
      lines = std::move(repeated);
    });
  }

  void cut_lines(const std::filesystem::path& csv, Span span) {
    edit(csv, [&](Lines& lines) {
      Lines kept;
      for (const std::string& line : lines) {
        if (!inside(span, line)) kept.push_back(line);
      }
      lines = std::move(kept);
    });
  }

  /// Stamps become `factor` * t + `shift_ns` from `from_s` on: clock jumps and other units.
  void move_stamps(const std::filesystem::path& csv,
                   double from_s,
                   std::int64_t shift_ns,
                   double factor = 1.0) {
    edit(csv, [&](Lines& lines) {
      for (std::string& line : lines) {
        const std::int64_t old_ns = stamp(line);
        if (seconds(old_ns) < from_s) continue;
        const auto scaled = factor == 1.0
                                ? old_ns
                                : static_cast<std::int64_t>(static_cast<double>(old_ns) * factor);
        line = std::to_string(scaled + shift_ns) + line.substr(line.find(','));
      }
    });
  }

  /// Takes out a piece of the recording and closes the gap in time, as if spliced from two.
  void splice(Span span) {
    const auto gap_ns = -static_cast<std::int64_t>((span.to_s - span.from_s) * 1e9);
    for (const auto& csv : {left_csv(), right_csv(), imu_csv(),
                            mav0() / "state_groundtruth_estimate0" / "data.csv"}) {
      cut_lines(csv, span);
      move_stamps(csv, span.to_s, gap_ns);
    }
  }

  // IMU ----------------------------------------------------------------------------------------

  void edit_imu(Span span, const std::function<void(Reading&)>& change) {
    edit(imu_csv(), [&](Lines& lines) {
      for (std::string& line : lines) {
        if (!inside(span, line)) continue;
        const auto cells = split(line, ',');
        Reading reading;
        for (std::size_t i = 0; i < reading.size(); ++i) reading.at(i) = cells.at(i + 1);
        change(reading);
        line = std::string(cells.at(0));
        for (const std::string& value : reading) line += "," + value;
      }
    });
  }

  void scale_imu(double gyro_factor, double accel_factor) {
    edit_imu(everything(), [&](Reading& reading) {
      for (std::size_t i = 0; i < reading.size(); ++i) {
        const double factor = i < 3 ? gyro_factor : accel_factor;
        reading.at(i) = std::to_string(std::stod(reading.at(i)) * factor);
      }
    });
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

  static constexpr Span everything() { return {-1e9, 1e9}; }

  static std::string read(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }

  static void write(const std::filesystem::path& file, const std::string& content) {
    std::filesystem::remove(file);  // never through a link into the base
    std::ofstream(file, std::ios::binary) << content;
  }

 private:
  template <typename Container>
  static std::int64_t last_index(const Container& container) {
    return static_cast<std::int64_t>(container.size()) - 1;
  }

  static Lines read_lines(const std::filesystem::path& csv) {
    std::ifstream stream(csv);
    Lines lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }

  static std::int64_t stamp(const std::string& line) { return std::stoll(line); }
  double seconds(std::int64_t time_ns) const {
    return static_cast<double>(time_ns - start_ns_) * 1e-9;
  }
  bool inside(Span span, const std::string& line) const {
    const double s = seconds(stamp(line));
    return s >= span.from_s && s < span.to_s;
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

  void change_bytes(Side side, double share, const std::function<void(std::string&)>& change) {
    for_images(side, [&](const auto& file) {
      if (!random_.chance(share)) return;
      std::string bytes = read(file);
      change(bytes);
      write(file, bytes);
    });
  }

  std::filesystem::path folder_;
  Random random_;
  std::int64_t start_ns_ = 0;
};

}  // namespace imslam::testing

#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/base/text.hpp"

namespace imslam::testing {

/// Spoils the tables in a copy of a EuRoC folder: stamps and IMU readings. The same seed and calls
/// always make the same damage. Text files are copies, images links: making one takes milliseconds.
/// Times are seconds since the first left image; intervals are half open.
class ChaosTables {
 public:
  struct Span {
    double from_s;
    double to_s;
  };
  using Lines = std::vector<std::string>;
  using Reading = std::array<std::string, 6>;  ///< gyro [rad/s], accelerometer [m/s^2] as text

  ChaosTables(const std::filesystem::path& base,
              std::filesystem::path folder,
              std::uint64_t seed = 1)
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

  static constexpr Span everything() { return {-1e9, 1e9}; }

  static std::string read(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }

  static void write(const std::filesystem::path& file, const std::string& content) {
    std::filesystem::remove(file);  // never through a link into the base
    std::ofstream(file, std::ios::binary) << content;
  }

 protected:
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

  std::filesystem::path folder_;
  Random random_;
  std::int64_t start_ns_ = 0;
};

}  // namespace imslam::testing

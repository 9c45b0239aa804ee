#include "slam/report/pcd_reader.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>

#include "slam/base/error.hpp"
#include "slam/base/text.hpp"

namespace imslam::report {
namespace {

constexpr std::size_t kMaxFields = 64;
constexpr std::size_t kMaxLine = 65536;
constexpr std::int64_t kMaxPoints = std::int64_t{1} << 40;
constexpr std::array<std::string_view, 4> kWanted = {"x", "y", "z", "intensity"};

struct Field {
  std::string name;
  std::int64_t size = 4;
  std::string type = "F";
  std::int64_t count = 1;
};

/// Where one of the wanted numbers stands in a record.
struct Place {
  std::size_t byte = 0;    ///< binary
  std::size_t column = 0;  ///< ascii
};

struct Header {
  std::vector<Field> fields;
  std::int64_t points = -1;
  bool binary = false;
  std::array<std::optional<Place>, kWanted.size()> places;
  std::size_t record_bytes = 0;
  std::size_t record_columns = 0;
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file)
      : file_(file), stream_(file, std::ios::binary) {
    if (!stream_) fail("cannot be opened; check the path and permissions");
  }

  PointCloud read(std::size_t limit) {
    read_header();
    place_fields();
    check_size();
    PointCloud cloud;
    cloud.total = static_cast<std::size_t>(header_.points);
    const std::size_t kept = std::min(limit, cloud.total);
    for (std::size_t i = 0; i < kept; ++i) {
      const auto index = static_cast<std::size_t>(
          static_cast<double>(i) * static_cast<double>(cloud.total) / static_cast<double>(kept));
      append(cloud, header_.binary ? binary_record(index) : ascii_record(index));
    }
    return cloud;
  }

 private:
  using Record = std::array<float, kWanted.size()>;

  [[noreturn]] void fail(const std::string& what) const {
    const std::string line = line_ > 0 ? fmt::format(":{}", line_) : "";
    throw InputError(fmt::format("{}{}: {}", file_.string(), line, what));
  }

  std::string next_line() {
    std::string line;
    ++line_;
    for (int c = stream_.get(); c != '\n'; c = stream_.get()) {
      if (c == std::char_traits<char>::eof()) {
        if (line.empty()) fail("expected more lines, found the end; write the map again");
        break;
      }
      if (line.size() >= kMaxLine) fail("expected a PCD file, found an endless line");
      line += static_cast<char>(c);
    }
    return line;
  }

  std::int64_t integer(std::string_view word, std::int64_t low, std::int64_t high) const {
    const auto value = parse_int64(word);
    if (!value || *value < low || *value > high) {
      fail(fmt::format("expected a whole number in [{}, {}]", low, high));
    }
    return *value;
  }

  void read_header() {
    for (bool data = false; !data;) {
      const std::string line = next_line();
      const std::string_view text = trim(line);
      if (text.empty() || text[0] == '#') continue;
      const auto words = split_blanks(text);
      data = words[0] == "DATA";
      read_entry(words);
    }
    line_ = header_.binary ? 0 : line_;
    if (header_.fields.empty()) fail("expected FIELDS before DATA");
    if (header_.points < 0) fail("expected POINTS before DATA");
  }

  void read_entry(const std::vector<std::string_view>& words) {
    const std::string_view key = words[0];
    if (key == "FIELDS") {
      if (words.size() < 2 || words.size() - 1 > kMaxFields) fail("expected 1 to 64 fields");
      header_.fields.resize(words.size() - 1);
    }
    const bool per_field = key == "FIELDS" || key == "SIZE" || key == "TYPE" || key == "COUNT";
    if (per_field && words.size() != header_.fields.size() + 1) {
      fail(fmt::format("expected {} values after {}", header_.fields.size(), key));
    }
    for (std::size_t i = 0; per_field && i < header_.fields.size(); ++i) {
      Field& field = header_.fields[i];
      if (key == "FIELDS") field.name = words[i + 1];
      if (key == "SIZE") field.size = integer(words[i + 1], 1, 8);
      if (key == "TYPE") field.type = words[i + 1];
      if (key == "COUNT") field.count = integer(words[i + 1], 1, 4096);
    }
    if (per_field) return;
    if (words.size() < 2) fail(fmt::format("expected a value after {}", key));
    if (key == "POINTS") header_.points = integer(words[1], 0, kMaxPoints);
    if (key != "DATA") return;
    header_.binary = words[1] == "binary";
    if (!header_.binary && words[1] != "ascii") fail("expected DATA ascii or DATA binary");
  }

  void place_fields() {
    for (const Field& field : header_.fields) {
      for (std::size_t k = 0; k < kWanted.size(); ++k) {
        if (field.name != kWanted[k]) continue;
        if (field.size != 4 || field.type != "F" || field.count != 1) {
          fail(fmt::format("expected field {} as one 4-byte float", field.name));
        }
        header_.places[k] = Place{header_.record_bytes, header_.record_columns};
      }
      header_.record_bytes += static_cast<std::size_t>(field.size * field.count);
      header_.record_columns += static_cast<std::size_t>(field.count);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (!header_.places[k]) fail("expected the fields x y z");
    }
  }

  void check_size() {
    if (!header_.binary) return;
    data_start_ = stream_.tellg();
    stream_.seekg(0, std::ios::end);
    const std::streamoff present = stream_.tellg() - data_start_;
    if (present / static_cast<std::streamoff>(header_.record_bytes) < header_.points) {
      fail(fmt::format("expected {} points of {} bytes, found {} bytes; write the map again",
                       header_.points, header_.record_bytes, present));
    }
  }

  Record binary_record(std::size_t index) {
    std::vector<char>& bytes = buffer_;
    bytes.resize(header_.record_bytes);
    if (index == 0 || index != next_record_) {  // a seek throws the stream's buffer away
      stream_.seekg(data_start_ + static_cast<std::streamoff>(index * header_.record_bytes));
    }
    next_record_ = index + 1;
    stream_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!stream_) fail("could not be read to its end");
    Record record{};
    for (std::size_t k = 0; k < kWanted.size(); ++k) {
      if (header_.places[k]) {
        std::memcpy(&record[k], bytes.data() + header_.places[k]->byte, sizeof(float));
      }
    }
    return record;
  }

  Record ascii_record(std::size_t index) {
    std::string line;
    for (; next_record_ <= index; ++next_record_) line = next_line();
    const auto words = split_blanks(trim(line));
    if (words.size() != header_.record_columns) {
      fail(fmt::format("expected {} numbers", header_.record_columns));
    }
    Record record{};
    for (std::size_t k = 0; k < kWanted.size(); ++k) {
      if (!header_.places[k]) continue;
      const auto value = parse_double(words[header_.places[k]->column]);
      if (!value) fail(fmt::format("expected a number for {}", kWanted[k]));
      record[k] = static_cast<float>(*value);
    }
    return record;
  }

  void append(PointCloud& cloud, const Record& record) const {
    const Eigen::Vector3f point(record[0], record[1], record[2]);
    if (!point.allFinite()) return;
    cloud.points.push_back(point);
    if (!header_.places[3]) return;
    cloud.intensities.push_back(std::isfinite(record[3]) ? record[3] : 0.0F);
  }

  std::filesystem::path file_;
  std::ifstream stream_;
  std::size_t line_ = 0;
  Header header_;
  std::streamoff data_start_ = 0;
  std::size_t next_record_ = 0;
  std::vector<char> buffer_;
};

}  // namespace

PointCloud read_pcd(const std::filesystem::path& file, std::size_t limit) {
  expects(limit > 0, "read_pcd: limit must be positive");
  return Reader(file).read(limit);
}

}  // namespace imslam::report

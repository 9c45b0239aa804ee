#include "datasets/trajectory_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <vector>

#include "slam/base/error.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/text.hpp"

namespace imslam::datasets {
namespace {

constexpr std::size_t kSizeLimit = std::size_t{1} << 30U;
constexpr std::size_t kLineLimit = std::size_t{64} << 10U;
constexpr double kNormTolerance = 1e-3;
constexpr std::string_view kFrameTag = "frame:";

/// Walks over the lines of a file; knows where it is for messages.
class Lines {
 public:
  Lines(const std::filesystem::path& file, std::string_view content) : file_(file), rest_(content) {
    constexpr std::string_view kBom = "\xEF\xBB\xBF";
    if (rest_.substr(0, kBom.size()) == kBom) rest_.remove_prefix(kBom.size());
  }

  /// Moves to the next line that is not empty, comments included; false at the end.
  bool next() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      if (std::min(end, rest_.size()) > kLineLimit) {
        ++number_;
        fail("line longer than 64 kB; is it a trajectory file?");
      }
      line_ = trim(rest_.substr(0, end));
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++number_;
      if (!line_.empty()) return true;
    }
    return false;
  }

  bool is_comment() const { return line_.front() == '#'; }
  std::string_view line() const { return line_; }

  [[noreturn]] void fail(const std::string& message, ExitCode code = ExitCode::kData) const {
    throw InputError(fmt::format("{}:{}: {}", file_.string(), number_, message), code);
  }
  std::string where() const { return fmt::format("{}:{}", file_.string(), number_); }

 private:
  const std::filesystem::path& file_;
  std::string_view rest_;
  std::string_view line_;
  int number_ = 0;
};

std::vector<std::string_view> columns_of(std::string_view line) {
  if (line.find(',') == std::string_view::npos) return split_blanks(line);
  std::vector<std::string_view> columns = split(line, ',');
  if (trim(columns.back()).empty()) columns.pop_back();
  return columns;
}

TrajectoryFormat format_of(const Lines& lines) {
  const std::size_t columns = columns_of(lines.line()).size();
  if (lines.line().find(',') != std::string_view::npos) {
    if (columns >= 8) return TrajectoryFormat::kEuroc;
    lines.fail(
        fmt::format("expected at least 8 comma-separated columns (EuRoC: time_ns, px, py, "
                    "pz, qw, qx, qy, qz), found {}",
                    columns));
  }
  if (columns == 8) return TrajectoryFormat::kTum;
  if (columns == 12) return TrajectoryFormat::kKitti;
  lines.fail(
      fmt::format("expected 8 blank-separated columns (TUM: time_s tx ty tz qx qy qz qw) or "
                  "12 (KITTI: 3x4 matrix, row by row), found {}",
                  columns));
}

/// The numbers of one line; all columns are parsed so that damage beyond the eighth is seen.
std::vector<double> numbers_of(const Lines& lines, std::size_t expected_columns) {
  const std::vector<std::string_view> columns = columns_of(lines.line());
  if (columns.size() != expected_columns) {
    lines.fail(fmt::format("expected {} columns as in the lines before, found {}; is the line cut?",
                           expected_columns, columns.size()));
  }
  std::vector<double> numbers;
  numbers.reserve(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::optional<double> number = parse_double(columns[i]);
    if (!number) {
      lines.fail(fmt::format("column {}: expected a number, found '{}'", i + 1, columns[i]));
    }
    if (!std::isfinite(*number)) {
      lines.fail(fmt::format("column {}: {} is not a pose that can be evaluated; remove the line",
                             i + 1, columns[i]),
                 ExitCode::kEvaluation);
    }
    numbers.push_back(*number);
  }
  return numbers;
}

/// Collects poses; counts quaternions that had to be normalised.
class PathBuilder {
 public:
  explicit PathBuilder(TrajectoryFormat format) : format_(format) {}

  void add(const Lines& lines, const std::vector<double>& n) {
    switch (format_) {
      case TrajectoryFormat::kTum:
        path_.stamps_s.push_back(n[0]);
        add_pose(lines, {n[1], n[2], n[3]}, {n[7], n[4], n[5], n[6]});
        break;
      case TrajectoryFormat::kEuroc:
        path_.stamps_s.push_back(n[0] / 1e9);
        add_pose(lines, {n[1], n[2], n[3]}, {n[4], n[5], n[6], n[7]});
        break;
      case TrajectoryFormat::kKitti:
        Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
        T.topRows<3>() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(n.data());
        path_.poses.push_back(T);
        break;
    }
  }

  PosePath finish() {
    if (unnormalised_ > 0) {
      log::warn("{}: {} of {} quaternions are not of unit length (first: norm {:.6g}); normalised",
                first_unnormalised_, unnormalised_, path_.size(), first_norm_);
    }
    return std::move(path_);
  }

 private:
  void add_pose(const Lines& lines, const Eigen::Vector3d& p, const Eigen::Quaterniond& q) {
    const double norm = q.norm();
    if (norm < 1e-6) {
      lines.fail("the quaternion is zero: no rotation; remove the line", ExitCode::kEvaluation);
    }
    if (std::abs(norm - 1.0) > kNormTolerance && unnormalised_++ == 0) {
      first_unnormalised_ = lines.where();
      first_norm_ = norm;
    }
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    T.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
    T.topRightCorner<3, 1>() = p;
    path_.poses.push_back(T);
  }

  TrajectoryFormat format_;
  PosePath path_;
  int unnormalised_ = 0;
  double first_norm_ = 1.0;
  std::string first_unnormalised_;
};

/// The word after "frame:" in a comment, as write_trajectory() leaves it.
std::string frame_of(std::string_view comment) {
  const std::size_t at = comment.find(kFrameTag);
  if (at == std::string_view::npos) return "";
  const auto words = split_blanks(comment.substr(at + kFrameTag.size()));
  return words.empty() ? "" : std::string(words.front());
}

std::string tum_stamp(std::int64_t time_ns) {
  const char* sign = time_ns < 0 ? "-" : "";
  const std::int64_t seconds = std::abs(time_ns / 1'000'000'000);
  return fmt::format("{}{}.{:09}", sign, seconds, std::abs(time_ns % 1'000'000'000));
}

void append_row(std::string& text, const std::vector<double>& numbers, char separator) {
  bool first = text.empty() || text.back() == '\n';
  for (const double number : numbers) {
    if (!first) text += separator;
    text += fmt::format("{}", number);  // shortest text that reads back as the same double
    first = false;
  }
  text += '\n';
}

std::vector<double> kitti_numbers(const lie::SE3d& T) {
  std::vector<double> numbers(12);
  Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers.data()) =
      T.matrix().topRows<3>();
  return numbers;
}

}  // namespace

TrajectoryFormat detect_trajectory_format(const std::filesystem::path& file) {
  const std::string content = read_file(file, kSizeLimit);
  Lines lines(file, content);
  while (lines.next()) {
    if (!lines.is_comment()) return format_of(lines);
  }
  throw InputError(file.string() + ": holds no poses; expected a TUM, KITTI or EuRoC trajectory");
}

PosePath read_trajectory(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_character_file(file, ignored)) {
    throw InputError(file.string() + ": not a regular file; give the trajectory file itself");
  }
  const std::string content = read_file(file, kSizeLimit);
  Lines lines(file, content);
  std::optional<PathBuilder> builder;
  std::size_t columns = 0;
  std::string frame;
  while (lines.next()) {
    if (lines.is_comment()) {
      if (frame.empty()) frame = frame_of(lines.line());
      continue;
    }
    if (!builder) {
      builder.emplace(format_of(lines));
      columns = columns_of(lines.line()).size();
    }
    builder->add(lines, numbers_of(lines, columns));
  }
  if (!builder) {
    throw InputError(file.string() + ": holds no poses; expected a TUM, KITTI or EuRoC trajectory");
  }
  PosePath path = builder->finish();
  path.frame = frame;
  path.source = file.string();
  return path;
}

void write_trajectory(const std::filesystem::path& file,
                      const Trajectory& trajectory,
                      TrajectoryFormat format) {
  expects(trajectory.times_ns.size() == trajectory.poses.size(),
          "write_trajectory: as many stamps as poses");
  std::string text;
  if (format == TrajectoryFormat::kTum) {
    text = fmt::format("# time_s tx ty tz qx qy qz qw (T_world_frame) {} {}\n", kFrameTag,
                       trajectory.frame);
  } else if (format == TrajectoryFormat::kEuroc) {
    text = fmt::format("#timestamp [ns],px [m],py [m],pz [m],qw,qx,qy,qz {} {}\n", kFrameTag,
                       trajectory.frame);
  }
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const lie::SE3d& T = trajectory.poses[i];
    const Eigen::Vector3d& p = T.translation();
    const Eigen::Quaterniond& q = T.rotation().quaternion();
    expects(p.allFinite() && q.coeffs().allFinite(), "write_trajectory: poses must be finite");
    switch (format) {
      case TrajectoryFormat::kTum:
        text += tum_stamp(trajectory.times_ns[i]);
        append_row(text, {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}, ' ');
        break;
      case TrajectoryFormat::kEuroc:
        text += fmt::format("{}", trajectory.times_ns[i]);
        append_row(text, {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()}, ',');
        break;
      case TrajectoryFormat::kKitti:
        append_row(text, kitti_numbers(T), ' ');
        break;
    }
  }
  write_file_atomic(file, text);
}

}  // namespace imslam::datasets

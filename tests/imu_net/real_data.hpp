#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "slam/base/text.hpp"
#include "slam/base/time.hpp"
#include "slam/sensors/imu.hpp"
#include "slam/sensors/motion.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::imu::testing {

/// Rows of numbers; comment lines are left out. For files known to be good only.
inline std::vector<std::vector<double>> read_rows(const std::filesystem::path& file) {
  std::vector<std::vector<double>> rows;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.front() == '#') continue;
    for (char& c : line) c = c == ',' ? ' ' : c;
    rows.emplace_back();
    for (const std::string_view word : split_blanks(line)) {
      rows.back().push_back(parse_double(word).value());
    }
  }
  return rows;
}

/// EuRoC column order; stamps are read as whole numbers.
inline std::vector<ImuSample> read_imu(const std::filesystem::path& file) {
  std::vector<ImuSample> samples;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.front() == '#') continue;
    const auto words = split(line, ',');
    const auto value = [&](std::size_t i) { return parse_double(words[i]).value(); };
    samples.push_back({parse_int64(words[0]).value(),
                       {value(1), value(2), value(3)},
                       {value(4), value(5), value(6)}});
  }
  return samples;
}

/// TUM file with stamps of full precision: T_world_body.
inline Trajectory read_tum(const std::filesystem::path& file) {
  Trajectory trajectory;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.front() == '#') continue;
    const auto words = split_blanks(line);
    const auto dot = words[0].find('.');
    std::string digits(words[0].substr(0, dot));
    std::string fraction(words[0].substr(dot + 1));
    fraction.resize(9, '0');
    digits += fraction;
    const auto value = [&](std::size_t i) { return parse_double(words[i]).value(); };
    const lie::SO3d R(Eigen::Quaterniond(value(7), value(4), value(5), value(6)));
    trajectory.add(parse_int64(digits).value(), lie::SE3d(R, {value(1), value(2), value(3)}));
  }
  return trajectory;
}

/// KITTI poses of camera 0, carried to the IMU; one pose per `times_ns`.
inline Trajectory read_kitti(const std::filesystem::path& file,
                             const lie::SE3d& T_left_body,
                             const std::vector<std::int64_t>& times_ns) {
  Trajectory trajectory;
  const auto rows = read_rows(file);
  for (std::size_t k = 0; k < rows.size() && k < times_ns.size(); ++k) {
    Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 12; ++i) M(i / 4, i % 4) = rows[k][static_cast<std::size_t>(i)];
    trajectory.add(times_ns[k], lie::SE3d::from_matrix(M) * T_left_body);
  }
  return trajectory;
}

/// The part of a trajectory between two poses, as if vision had measured it at shifted stamps.
inline std::vector<RelativeMotion> as_vision(const Trajectory& truth,
                                             std::size_t first,
                                             std::size_t last,
                                             std::size_t stride,
                                             std::int64_t shift_ns,
                                             double rotation_std) {
  std::vector<RelativeMotion> motions;
  for (std::size_t i = first; i + stride < last; i += stride) {
    RelativeMotion motion;
    motion.time0_ns = truth.times_ns[i] + shift_ns;
    motion.time1_ns = truth.times_ns[i + stride] + shift_ns;
    motion.T_body0_body1 = truth.poses[i].inverse() * truth.poses[i + stride];
    motion.covariance *= rotation_std * rotation_std;
    motion.valid = true;
    motions.push_back(motion);
  }
  return motions;
}

}  // namespace imslam::imu::testing

#include "datasets/oxts.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "datasets/stamp_file.hpp"
#include "slam/base/file.hpp"
#include "slam/base/log.hpp"
#include "slam/base/text.hpp"
#include "slam/base/time.hpp"
#include "slam/lie/se3.hpp"

namespace imslam::datasets {
namespace {

constexpr double kEarthRadius_m = 6378137.0;
constexpr double kRadiansPerDegree = 0.017453292519943295;
constexpr std::size_t kFieldCount = 30;
constexpr std::size_t kMaxPacketBytes = 4096;
constexpr std::int64_t kMaxLatenessNs = 5'000'000'000;
constexpr std::int64_t kMaxInterpolationNs = 300'000'000;

bool parse_packet(const std::string& text, OxtsPacket& packet) {
  const auto words = split_blanks(text);
  if (words.size() < kFieldCount - 5) return false;  // the last five are status counters
  std::vector<double> v;
  for (std::size_t i = 0; i < 23; ++i) {
    const auto number = parse_double(words[i]);
    if (!number || !std::isfinite(*number)) return false;
    v.push_back(*number);
  }
  packet.latitude_deg = v[0];
  packet.longitude_deg = v[1];
  packet.altitude_m = v[2];
  packet.roll = v[3];
  packet.pitch = v[4];
  packet.yaw = v[5];
  packet.linear_acceleration = {v[11], v[12], v[13]};
  packet.angular_velocity = {v[17], v[18], v[19]};
  return std::abs(packet.latitude_deg) < 89.0;
}

/// False if the file is missing or damaged.
bool read_packet(const std::filesystem::path& file, OxtsPacket& packet) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;
  try {
    return parse_packet(read_file(file, kMaxPacketBytes), packet);
  } catch (const InputError&) {
    return false;
  }
}

lie::SE3d pose(const OxtsPacket& packet, double scale) {
  const double lon = packet.longitude_deg * kRadiansPerDegree;
  const double lat = packet.latitude_deg * kRadiansPerDegree;
  const Eigen::Vector3d p(scale * kEarthRadius_m * lon,
                          scale * kEarthRadius_m * std::log(std::tan(M_PI / 4 + lat / 2)),
                          packet.altitude_m);
  const Eigen::Quaterniond q = Eigen::AngleAxisd(packet.yaw, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(packet.pitch, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(packet.roll, Eigen::Vector3d::UnitX());
  return {lie::SO3d(q), p};
}

lie::SE3d interpolate(const lie::SE3d& a, const lie::SE3d& b, double fraction) {
  const lie::SO3d R =
      a.rotation() * lie::SO3d::exp(fraction * (a.rotation().inverse() * b.rotation()).log());
  return {R, a.translation() + fraction * (b.translation() - a.translation())};
}

}  // namespace

std::vector<OxtsPacket> read_oxts(const std::filesystem::path& oxts_folder) {
  const auto stamps = read_timestamps_file(oxts_folder / "timestamps.txt");
  std::vector<OxtsPacket> packets;
  std::size_t without_stamp = 0;
  std::size_t damaged = 0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (!stamps[i]) {
      ++without_stamp;
      continue;
    }
    OxtsPacket packet;
    packet.index = i;
    packet.time_ns = *stamps[i];
    if (read_packet(oxts_folder / "data" / fmt::format("{:010d}.txt", i), packet)) {
      packets.push_back(packet);
    } else {
      ++damaged;
    }
  }
  if (without_stamp + damaged > 0) {
    log::warn("{}: skipped {} packets without stamp and {} missing or damaged ones",
              oxts_folder.string(), without_stamp, damaged);
  }
  if (packets.empty()) {
    throw InputError(oxts_folder.string() +
                     ": no readable OXTS packet in data/; unpack the drive "
                     "again");
  }
  return packets;
}

ImuTable oxts_imu(const std::vector<OxtsPacket>& packets, const std::string& name) {
  std::vector<ImuRow> rows;
  rows.reserve(packets.size());
  for (const OxtsPacket& packet : packets) {
    rows.push_back(
        {packet.index + 1, {packet.time_ns, packet.angular_velocity, packet.linear_acceleration}});
  }
  ImuTable table = clean_imu(std::move(rows), name, kMaxLatenessNs);
  log_cleaning(name, table.cleaning);
  return table;
}

PosePath oxts_path(std::vector<OxtsPacket> packets, const std::vector<std::int64_t>& times_ns) {
  PosePath path;
  path.frame = "body";
  if (packets.empty()) return path;
  std::stable_sort(packets.begin(), packets.end(),
                   [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; });
  const double scale = std::cos(packets.front().latitude_deg * kRadiansPerDegree);
  const Eigen::Vector3d origin = pose(packets.front(), scale).translation();
  for (const std::int64_t time_ns : times_ns) {
    const auto after =
        std::lower_bound(packets.begin(), packets.end(), time_ns,
                         [](const OxtsPacket& p, std::int64_t t) { return p.time_ns < t; });
    if (after == packets.end() || (after == packets.begin() && after->time_ns != time_ns)) continue;
    const auto before = after->time_ns == time_ns ? after : after - 1;
    const std::int64_t interval_ns = after->time_ns - before->time_ns;
    if (interval_ns > kMaxInterpolationNs) continue;
    const double fraction =
        interval_ns == 0 ? 0.0 : to_seconds(time_ns - before->time_ns) / to_seconds(interval_ns);
    Eigen::Matrix4d T = interpolate(pose(*before, scale), pose(*after, scale), fraction).matrix();
    T.topRightCorner<3, 1>() -= origin;
    path.stamps_s.push_back(to_seconds(time_ns));
    path.poses.push_back(T);
  }
  return path;
}

}  // namespace imslam::datasets

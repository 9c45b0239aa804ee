#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "datasets/imu_csv.hpp"
#include "slam/sensors/trajectory.hpp"

namespace imslam::datasets {

/// One packet of KITTI's OXTS RT3003 inertial and GPS unit. Body: x forward, y left, z up.
struct OxtsPacket {
  std::int64_t time_ns = 0;
  std::size_t index = 0;  ///< number of the file
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double altitude_m = 0.0;
  double roll = 0.0;   ///< [rad]
  double pitch = 0.0;  ///< [rad]
  double yaw = 0.0;    ///< [rad], 0 = east, counter-clockwise
  Eigen::Vector3d linear_acceleration = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();     ///< [rad/s]
};

/// Reads `oxts/timestamps.txt` and `oxts/data/*.txt` in file order. Packets without stamp (empty
/// lines occur), without file or with damaged content are skipped, with one warning.
/// InputError(kData) if no packet is left.
std::vector<OxtsPacket> read_oxts(const std::filesystem::path& oxts_folder);

/// The inertial part, sorted and cleaned: the 100 Hz recordings of _extract are not in order.
ImuTable oxts_imu(const std::vector<OxtsPacket>& packets, const std::string& name);

/// T_world_body at the given stamps, interpolated between packets at most 0.3 s apart; stamps
/// without such packets are left out. World: mercator, east-north-up, origin at the first packet.
///
///   s = cos(lat0),  x = s r lon,  y = s r ln tan(pi/4 + lat/2),  R = Rz(yaw) Ry(pitch) Rx(roll)
///
/// Source: KITTI raw development kit, convertOxtsToPose.
PosePath oxts_path(std::vector<OxtsPacket> packets, const std::vector<std::int64_t>& times_ns);

}  // namespace imslam::datasets

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "slam/lie/se3.hpp"

namespace imslam {

/// Poses of one frame over time, as the program estimates them. Stamps strictly increase.
struct Trajectory {
  std::vector<std::int64_t> times_ns;
  std::vector<lie::SE3d> poses;  ///< T_world_frame
  std::string frame = "body";    ///< "body" or "left"

  std::size_t size() const { return poses.size(); }
  void add(std::int64_t time_ns, const lie::SE3d& T_world_frame) {
    times_ns.push_back(time_ns);
    poses.push_back(T_world_frame);
  }
};

/// Poses exactly as a file gives them. Evaluation works on these: evo compares stamps as doubles
/// and uses KITTI matrices without making them orthonormal.
struct PosePath {
  std::vector<double> stamps_s;        ///< [s]; empty for files without stamps (KITTI)
  std::vector<Eigen::Matrix4d> poses;  ///< T_world_frame
  std::string frame;                   ///< "body", "left", or "" where the file does not say
  std::string source;                  ///< file name, for messages

  std::size_t size() const { return poses.size(); }
  bool has_stamps() const { return !stamps_s.empty(); }
};

}  // namespace imslam

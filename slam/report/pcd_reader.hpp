#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <vector>

namespace imslam::report {

struct PointCloud {
  std::vector<Eigen::Vector3f> points;  ///< [m], all finite
  std::vector<float> intensities;       ///< as in the file; empty if it has none
  std::size_t total = 0;                ///< points in the file
};

/// Reads a PCD file (version 0.7, DATA ascii or binary) whose fields x, y, z and, if present,
/// intensity are 4-byte floats; other fields are skipped.
///
/// Keeps at most `limit` points, evenly spread over the file, the same at every call. Points that
/// are not finite are left out. Memory is bounded by `limit`, whatever the header claims.
/// Throws InputError "file: expected ...".
PointCloud read_pcd(const std::filesystem::path& file, std::size_t limit);

}  // namespace imslam::report

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slam/evaluation/statistics.hpp"

namespace imslam::evaluation {

/// One result as evo stores it, so that `evo_res` can set it beside others.
struct EvoResult {
  std::string title;
  std::string label;  ///< e.g. "APE (m)"
  std::string reference_name;
  std::string estimate_name;
  Statistics stats;
  std::vector<double> errors;
  /// Per error; empty where the paths have no stamps.
  std::vector<double> timestamps_s;            ///< [s]
  std::vector<double> seconds_from_start_s;    ///< [s]
  std::vector<double> distances_from_start_m;  ///< [m], along the reference
  std::vector<double> distances_m;             ///< [m], along the estimate
  std::optional<Eigen::Matrix4d> T_alignment;  ///< [scale R, t; 0 1]
};

/// The bytes of an uncompressed zip: info.json, stats.json and numpy arrays. The same for the same
/// result, at any time.
std::string evo_archive(const EvoResult& result);

/// Writes it atomically. Throws InputError(kOutput).
void write_evo_archive(const std::filesystem::path& file, const EvoResult& result);

/// The bytes of a numpy file, format 1.0, little-endian doubles in C order.
/// Source: numpy.lib.format, NEP 1.
std::string npy(const std::vector<double>& values);
std::string npy(const Eigen::Matrix4d& matrix);

}  // namespace imslam::evaluation

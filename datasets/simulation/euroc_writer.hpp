#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "datasets/simulation/simulator.hpp"

namespace imslam::simulation {

/// A text file that is written line by line; throws InputError(kOutput) if the disk is full.
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& file, const std::string& header);
  void line(const std::string& text);
  void close();

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
};

/// Writes the pieces of a sequence in EuRoC's ASL layout into one folder.
class EurocWriter {
 public:
  /// Makes the folders and sensor files below `root`.
  EurocWriter(const std::filesystem::path& root, const Simulator& simulator);

  void add_imu(const SimulatedImuSample& sample);

  /// Encodes and writes a batch in parallel. An empty image is left out of folder and index.
  void add_frames(const std::vector<SimulatedFrame>& frames);

  void close();

 private:
  std::filesystem::path mav_;
  CsvWriter left_;
  CsvWriter right_;
  CsvWriter imu_;
  CsvWriter truth_;
};

/// The depth and flow images as OpenCV PNG bytes; documented at simulate().
std::vector<unsigned char> encode_depth(const SimulatedFrame& frame);
std::vector<unsigned char> encode_flow(const SimulatedFrame& frame);

}  // namespace imslam::simulation

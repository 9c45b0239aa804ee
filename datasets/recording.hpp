#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/image_index.hpp"
#include "datasets/image_io.hpp"
#include "datasets/rectify.hpp"
#include "datasets/sequence.hpp"
#include "slam/base/error.hpp"

namespace imslam::datasets {

/// Everything a reader finds out about a folder: each format is a function that fills this in.
struct Recording {
  Recording(std::string format_name, StereoRectifier stereo_rectifier)
      : format(std::move(format_name)), rectifier(std::move(stereo_rectifier)) {}

  std::string format;
  std::string name;
  std::filesystem::path root;

  StereoRectifier rectifier;  ///< its camera's T_body_left is relative to the IMU if there is one
  std::filesystem::path left_folder;
  std::filesystem::path right_folder;
  std::vector<FramePair> frames;  ///< strictly increasing stamps

  std::optional<ImuData> imu;
  std::optional<PosePath> truth;
  lie::SE3d T_body_truth;
  std::optional<InputError> truth_fault;  ///< why the truth that is there is not used

  std::string calibration_file;
  std::vector<std::filesystem::path> input_files;
};

/// A sequence that can also show its pairs the other way round: the files of the right camera taken
/// as left images, before rectification.
class ExchangeableSequence : public Sequence {
 public:
  virtual StereoFrame read_exchanged_frame(std::size_t index) = 0;
};

/// Finds out the format (see open_sequence()) and what is in the folder.
Recording read_recording(const std::filesystem::path& folder, const std::string& format);

/// The sequence over a recording. Where there is no IMU the rectified left camera becomes the body.
///
/// InputError(kData) if there are no frames or no image can be read; InputError(kCalibration) if
/// the images have another size than the calibration says.
std::unique_ptr<Sequence> make_sequence(Recording recording);

/// The truth of that file, of `frame`. A file with a flaw costs the figures, not the run: it is
/// warned of and becomes the truth_fault.
void read_truth_file(const std::filesystem::path& file,
                     const std::string& frame,
                     Recording& recording);

/// Size that most of a few probed images have; empty if none can be read.
std::optional<ImageSize> common_image_size(const std::filesystem::path& folder,
                                           const std::vector<std::string>& names);

/// Name for messages and run folders: the last part of the absolute path that is no "mav0" or ".".
std::string folder_name(const std::filesystem::path& folder);

}  // namespace imslam::datasets

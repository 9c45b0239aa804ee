#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace imslam::datasets {

/// Which raw drive an odometry sequence was cut from (KITTI odometry development kit).
struct KittiDrive {
  std::string sequence;   ///< "00"
  std::string date;       ///< "2011_10_03"
  std::string number;     ///< "0027"
  std::size_t first = 0;  ///< first and last image of the drive in the sequence
  std::size_t last = 0;

  std::string name() const { return date + "_drive_" + number; }
};

const std::vector<KittiDrive>& kitti_drives();

/// InputError(kData) for 03, whose drive is not published; empty for other names.
std::optional<KittiDrive> drive_of_sequence(const std::string& sequence);

/// A drive folder by its name DATE_drive_NUMBER[_sync|_extract].
struct DriveFolders {
  std::filesystem::path date;     ///< holds the calibration
  std::filesystem::path sync;     ///< rectified images
  std::filesystem::path extract;  ///< OXTS at 100 Hz
};

/// The folders of the drive that `folder` belongs to; empty if its name is not of that form.
std::optional<DriveFolders> drive_folders(const std::filesystem::path& folder);

/// The folders of a drive below a KITTI raw root that holds DATE/DATE_drive_NUMBER_extract or
/// _sync; looked for in `root`, in raw, kitti_raw, raw_data inside or beside it, and beside it.
std::optional<DriveFolders> find_drive(const std::filesystem::path& root, const KittiDrive& drive);

}  // namespace imslam::datasets

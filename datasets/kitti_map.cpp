#include "datasets/kitti_map.hpp"

#include "slam/base/error.hpp"
#include "slam/base/text.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;

std::optional<DriveFolders> folders_below(const fs::path& root, const KittiDrive& drive) {
  const fs::path date = root / drive.date;
  const DriveFolders folders{date, date / (drive.name() + "_sync"),
                             date / (drive.name() + "_extract")};
  const bool found = fs::is_directory(folders.sync) || fs::is_directory(folders.extract);
  return found ? std::optional(folders) : std::nullopt;
}

/// "2011_10_03_drive_0027": a date, "drive" and a number.
bool is_drive_name(const std::string& name) {
  const auto parts = split(name, '_');
  if (parts.size() != 5 || parts[3] != "drive") return false;
  for (const std::size_t i : {0U, 1U, 2U, 4U}) {
    if (!parse_int64(parts[i])) return false;
  }
  return true;
}

}  // namespace

const std::vector<KittiDrive>& kitti_drives() {
  static const std::vector<KittiDrive> drives = {
      {"00", "2011_10_03", "0027", 0, 4540},    {"01", "2011_10_03", "0042", 0, 1100},
      {"02", "2011_10_03", "0034", 0, 4660},    {"03", "2011_09_26", "0067", 0, 800},
      {"04", "2011_09_30", "0016", 0, 270},     {"05", "2011_09_30", "0018", 0, 2760},
      {"06", "2011_09_30", "0020", 0, 1100},    {"07", "2011_09_30", "0027", 0, 1100},
      {"08", "2011_09_30", "0028", 1100, 5170}, {"09", "2011_09_30", "0033", 0, 1590},
      {"10", "2011_09_30", "0034", 0, 1200}};
  return drives;
}

std::optional<KittiDrive> drive_of_sequence(const std::string& sequence) {
  for (const KittiDrive& drive : kitti_drives()) {
    if (drive.sequence != sequence) continue;
    if (sequence == "03") {
      throw InputError("KITTI odometry 03 was cut from " + drive.name() +
                       ", which is not published: there is no IMU for it; run it without raw data");
    }
    return drive;
  }
  return std::nullopt;
}

std::optional<DriveFolders> drive_folders(const fs::path& folder) {
  const fs::path path = fs::absolute(folder / ".").lexically_normal().parent_path();
  std::string name = path.filename().string();
  for (const std::string suffix : {"_sync", "_extract"}) {
    if (name.size() > suffix.size() &&
        name.compare(name.size() - suffix.size(), suffix.size(), suffix) == 0) {
      name.resize(name.size() - suffix.size());
    }
  }
  if (!is_drive_name(name)) return std::nullopt;
  const fs::path date = path.parent_path();
  return DriveFolders{date, date / (name + "_sync"), date / (name + "_extract")};
}

std::optional<DriveFolders> find_drive(const fs::path& root, const KittiDrive& drive) {
  const fs::path beside = root.parent_path();
  for (const fs::path& base : {root, root / "raw", root / "kitti_raw", root / "raw_data",
                               beside / "raw", beside / "kitti_raw", beside / "raw_data", beside}) {
    if (const auto folders = folders_below(base, drive)) return folders;
  }
  return std::nullopt;
}

}  // namespace imslam::datasets

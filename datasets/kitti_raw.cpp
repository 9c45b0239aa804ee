#include "datasets/kitti_raw.hpp"

#include <algorithm>
#include <limits>

#include "datasets/kitti_calibration.hpp"
#include "datasets/kitti_odometry.hpp"
#include "datasets/oxts.hpp"
#include "datasets/stamp_file.hpp"
#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMarginNs = 1'000'000'000;  // IMU kept before and after the images

/// Frames [first, last] of a drive.
struct DriveRange {
  DriveFolders folders;
  std::string name;
  std::size_t first = 0;
  std::size_t last = std::numeric_limits<std::size_t>::max();
};

/// `RAW/NN` for an odometry number, with RAW holding the folder of the drive's date.
std::optional<DriveRange> range_by_number(const fs::path& path) {
  if (fs::exists(path)) return std::nullopt;
  const bool raw_root = std::any_of(
      kitti_drives().begin(), kitti_drives().end(),
      [&](const KittiDrive& drive) { return fs::is_directory(path.parent_path() / drive.date); });
  const auto drive = raw_root ? drive_of_sequence(path.filename().string()) : std::nullopt;
  if (!drive) return std::nullopt;
  const auto folders = find_drive(path.parent_path(), *drive);
  if (!folders) {
    throw InputError(fmt::format("{}: odometry {} is {}/{}_sync, which is not here; download it",
                                 path.string(), drive->sequence, drive->date, drive->name()));
  }
  return DriveRange{*folders, drive->sequence, drive->first, drive->last};
}

DriveRange range_of(const fs::path& folder) {
  if (auto range = range_by_number(folder)) return *range;
  const auto folders = drive_folders(folder);
  if (!folders) {
    throw InputError(folder.string() +
                     ": expected a drive folder named like 2011_10_03_drive_0027_sync");
  }
  return {*folders, folders->sync.filename().string()};
}

struct CameraNumbers {
  std::string left;
  std::string right;
};

CameraNumbers camera_numbers(const fs::path& sync) {
  const auto has = [&](const char* left, const char* right) {
    return fs::is_directory(sync / left) && fs::is_directory(sync / right);
  };
  if (has("image_00", "image_01")) return {"00", "01"};
  if (has("image_02", "image_03")) return {"02", "03"};
  throw InputError(sync.string() +
                   ": expected image_00 and image_01, or image_02 and image_03; "
                   "give the rectified (_sync) drive, both cameras unpacked");
}

StereoRectifier read_cameras(const fs::path& date, const CameraNumbers& numbers) {
  const KittiCalibration calibration(date / "calib_cam_to_cam.txt");
  KittiPair pair = kitti_pair(calibration, "P_rect_" + numbers.left, "P_rect_" + numbers.right);
  const Eigen::Vector2d size = calibration.vector2("S_rect_" + numbers.left);
  pair.camera.width = static_cast<int>(size.x());
  pair.camera.height = static_cast<int>(size.y());
  return StereoRectifier(pair.camera);
}

/// p_cam0 = T p_imu, cam0 rectified.
lie::SE3d read_T_cam0_imu(const fs::path& date) {
  const KittiCalibration cameras(date / "calib_cam_to_cam.txt");
  const KittiCalibration velo(date / "calib_velo_to_cam.txt");
  const KittiCalibration imu(date / "calib_imu_to_velo.txt");
  const lie::SE3d R_rect = cameras.rotation("R_rect_00");
  return R_rect * velo.rigid("R", "T") * imu.rigid("R", "T");
}

std::vector<FramePair> read_frames(const DriveRange& drive, const Recording& recording) {
  const fs::path file = recording.left_folder.parent_path() / "timestamps.txt";
  const auto stamps = read_timestamps_file(file);
  const auto left = names_by_frame(list_images(recording.left_folder), stamps.size());
  const auto right = names_by_frame(list_images(recording.right_folder), stamps.size());
  std::vector<ImageEntry> entries;
  for (std::size_t i = drive.first; i < stamps.size() && i <= drive.last; ++i) {
    if (stamps[i]) entries.push_back({*stamps[i], std::to_string(i), i + 1});
  }
  std::vector<FramePair> frames;
  for (const ImageEntry& entry : clean_images(std::move(entries), file.string())) {
    const std::size_t i = entry.line - 1;
    frames.push_back({entry.time_ns, left[i], right[i]});
  }
  return frames;
}

void trim(std::vector<ImuSample>& samples, std::int64_t first_ns, std::int64_t last_ns) {
  samples.erase(std::remove_if(samples.begin(), samples.end(),
                               [&](const ImuSample& sample) {
                                 return sample.time_ns < first_ns - kMarginNs ||
                                        sample.time_ns > last_ns + kMarginNs;
                               }),
                samples.end());
}

void read_imu_and_truth(const DriveRange& drive, Recording& recording) {
  const bool fast = fs::exists(drive.folders.extract / "oxts" / "timestamps.txt");
  const fs::path oxts = (fast ? drive.folders.extract : drive.folders.sync) / "oxts";
  if (!fs::exists(oxts / "timestamps.txt")) return;
  const std::vector<OxtsPacket> packets = read_oxts(oxts);
  const lie::SE3d T_imu_cam0 = read_T_cam0_imu(drive.folders.date).inverse();
  const std::int64_t first_ns = recording.frames.front().time_ns;
  const std::int64_t last_ns = recording.frames.back().time_ns;
  std::vector<std::int64_t> times;
  for (const FramePair& frame : recording.frames) times.push_back(frame.time_ns);
  recording.truth = oxts_path(packets, times);
  recording.truth->source = oxts.string();
  if (recording.truth->size() == 0) recording.truth.reset();
  recording.input_files.push_back(oxts / "timestamps.txt");

  StereoCamera camera = recording.rectifier.camera();
  camera.T_body_left = T_imu_cam0 * camera.T_body_left;
  recording.rectifier = StereoRectifier(camera);
  if (!fast) {
    log::warn("{}: no 100 Hz IMU (oxts of the _extract drive); running without IMU",
              drive.folders.extract.string());
    return;
  }
  ImuTable table = oxts_imu(packets, oxts.string());
  trim(table.samples, first_ns, last_ns);
  if (table.samples.empty()) {
    log::warn("{}: no packet between the first and the last image; running without IMU",
              oxts.string());
    return;
  }
  recording.imu = ImuData{kitti_imu_noise(), std::move(table.samples), table.cleaning.dropped()};
}

}  // namespace

bool looks_like_kitti_raw(const fs::path& folder) {
  return range_by_number(folder).has_value() ||
         (fs::is_directory(folder) && drive_folders(folder).has_value());
}

Recording read_kitti_raw(const fs::path& folder) {
  const DriveRange drive = range_of(folder);
  const CameraNumbers numbers = camera_numbers(drive.folders.sync);
  const fs::path& date = drive.folders.date;
  Recording recording("kitti_raw", read_cameras(date, numbers));
  recording.name = drive.name;
  recording.root = drive.folders.sync;
  recording.left_folder = drive.folders.sync / ("image_" + numbers.left) / "data";
  recording.right_folder = drive.folders.sync / ("image_" + numbers.right) / "data";
  recording.calibration_file = (date / "calib_cam_to_cam.txt").string();
  recording.input_files = {date / "calib_cam_to_cam.txt",
                           recording.left_folder.parent_path() / "timestamps.txt"};
  recording.frames = read_frames(drive, recording);
  if (!recording.frames.empty()) read_imu_and_truth(drive, recording);
  if (recording.imu) {
    recording.input_files.insert(recording.input_files.end(),
                                 {date / "calib_velo_to_cam.txt", date / "calib_imu_to_velo.txt"});
  }
  return recording;
}

std::optional<RawImu> find_raw_imu(const fs::path& odometry_root,
                                   const std::string& sequence,
                                   std::int64_t first_time_ns,
                                   std::int64_t last_time_ns) {
  const auto known = std::find_if(kitti_drives().begin(), kitti_drives().end(),
                                  [&](const auto& drive) { return drive.sequence == sequence; });
  if (known == kitti_drives().end()) return std::nullopt;
  const auto folders = find_drive(odometry_root, *known);
  if (!folders || !fs::exists(folders->extract / "oxts" / "timestamps.txt")) {
    log::info("{}: no IMU; put imu.csv and T_cam0_imu.txt there, or KITTI raw {}/{}_extract {}",
              sequence, known->date, known->name(),
              sequence == "03" ? "(not published for 03)" : "near the odometry root");
    return std::nullopt;
  }
  // Odometry frames are numbered like those of _sync, whose stamps are on the IMU's clock.
  const fs::path images =
      fs::exists(folders->sync / "image_00" / "timestamps.txt") ? folders->sync : folders->extract;
  const auto stamps = read_timestamps_file(images / "image_00" / "timestamps.txt");
  if (known->first >= stamps.size() || !stamps[known->first]) {
    throw InputError(
        fmt::format("{}: line {} should hold the stamp of the first frame of odometry "
                    "{}; unpack the drive again",
                    (images / "image_00" / "timestamps.txt").string(), known->first + 1, sequence));
  }
  const fs::path oxts = folders->extract / "oxts";
  ImuTable table = oxts_imu(read_oxts(oxts), oxts.string());
  for (ImuSample& sample : table.samples) {
    sample.time_ns += first_time_ns - *stamps[known->first];
  }
  trim(table.samples, first_time_ns, last_time_ns);
  if (table.samples.empty()) {
    log::warn("{}: no packet between the first and the last image; running without IMU",
              oxts.string());
    return std::nullopt;
  }
  RawImu raw;
  raw.imu = ImuData{kitti_imu_noise(), std::move(table.samples), table.cleaning.dropped()};
  raw.T_velo_imu = KittiCalibration(folders->date / "calib_imu_to_velo.txt").rigid("R", "T");
  raw.files = {oxts / "timestamps.txt", folders->date / "calib_imu_to_velo.txt"};
  return raw;
}

}  // namespace imslam::datasets

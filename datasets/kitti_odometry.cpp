#include "datasets/kitti_odometry.hpp"

#include <algorithm>

#include "datasets/imu_csv.hpp"
#include "datasets/kitti_calibration.hpp"
#include "datasets/kitti_raw.hpp"
#include "datasets/stamp_file.hpp"
#include "datasets/trajectory_file.hpp"
#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;

bool is_sequence(const fs::path& folder) {
  return fs::exists(folder / "calib.txt") &&
         (fs::is_directory(folder / "image_0") || fs::is_directory(folder / "image_2"));
}

std::vector<fs::path> sequences_of(const fs::path& root) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(root / "sequences", error), end; !error && entry != end;
       entry.increment(error)) {
    if (is_sequence(entry->path())) found.push_back(entry->path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

fs::path sequence_folder(const fs::path& folder) {
  if (is_sequence(folder)) return folder;
  const auto found = sequences_of(folder);
  if (found.size() == 1) return found.front();
  std::string names;
  for (const fs::path& path : found) names += " " + path.string();
  throw InputError(folder.string() +
                   (found.empty()
                        ? ": no KITTI odometry sequence (calib.txt, image_0, image_1) here"
                        : ": holds several sequences; give one of them:" + names));
}

/// Grey pair if present, else the colour pair.
std::pair<std::string, std::string> camera_numbers(const fs::path& folder) {
  const bool grey = fs::is_directory(folder / "image_0") && fs::is_directory(folder / "image_1");
  if (!grey && !(fs::is_directory(folder / "image_2") && fs::is_directory(folder / "image_3"))) {
    throw InputError(folder.string() +
                     ": expected image_0 and image_1, or image_2 and image_3; "
                     "unpack both cameras of the pair");
  }
  return grey ? std::pair{"0", "1"} : std::pair{"2", "3"};
}

std::vector<FramePair> read_frames(const fs::path& folder, const Recording& recording) {
  const auto times = read_times_file(folder / "times.txt");
  const auto left_names = list_images(recording.left_folder);
  const auto right_names = list_images(recording.right_folder);
  if (left_names.size() != times.size() || right_names.size() != times.size()) {
    log::warn("{}: {} stamps, but {} left and {} right images", (folder / "times.txt").string(),
              times.size(), left_names.size(), right_names.size());
  }
  const auto left = names_by_frame(left_names, times.size());
  const auto right = names_by_frame(right_names, times.size());
  std::vector<FramePair> frames;
  frames.reserve(times.size());
  for (std::size_t i = 0; i < times.size(); ++i) frames.push_back({times[i], left[i], right[i]});
  return frames;
}

void set_imu(ImuData imu, const lie::SE3d& T_cam0_imu, Recording& recording) {
  StereoCamera camera = recording.rectifier.camera();
  camera.T_body_left = T_cam0_imu.inverse() * camera.T_body_left;
  recording.rectifier = StereoRectifier(camera);
  recording.T_body_truth = T_cam0_imu.inverse();
  recording.imu = std::move(imu);
}

void read_raw_imu(const fs::path& folder, Recording& recording) {
  const KittiCalibration calibration(folder / "calib.txt");
  if (!calibration.has("Tr") || recording.frames.empty()) return;
  auto raw = find_raw_imu(folder.parent_path().parent_path(), folder.filename().string(),
                          recording.frames.front().time_ns, recording.frames.back().time_ns);
  if (!raw) return;
  set_imu(std::move(raw->imu), calibration.rigid34("Tr") * raw->T_velo_imu, recording);
  recording.input_files.insert(recording.input_files.end(), raw->files.begin(), raw->files.end());
}

void read_imu(const fs::path& folder, Recording& recording) {
  const fs::path csv = folder / "imu.csv";
  const fs::path extrinsics = folder / "T_cam0_imu.txt";
  if (!fs::exists(csv)) {
    read_raw_imu(folder, recording);
    return;
  }
  ImuTable table = read_imu_csv(csv);
  if (table.samples.empty()) {
    throw InputError(csv.string() + ": no samples; remove the file to run without IMU");
  }
  const ImuData imu{kitti_imu_noise(), std::move(table.samples), table.cleaning.dropped()};
  set_imu(imu, read_rigid_motion_file(extrinsics), recording);
  recording.input_files.insert(recording.input_files.end(), {csv, extrinsics});
}

fs::path truth_beside(const fs::path& folder) {
  const fs::path root = folder.parent_path().parent_path();
  return root / "poses" / (folder.filename().string() + ".txt");
}

void read_truth(const fs::path& folder, Recording& recording) {
  fs::path file = truth_beside(folder);
  std::error_code ignored;  // reading it says what is wrong with it
  // A link to a sequence stands elsewhere than the sequence.
  if (fs::symlink_status(file, ignored).type() == fs::file_type::not_found) {
    file = truth_beside(fs::canonical(folder));
  }
  if (fs::symlink_status(file, ignored).type() == fs::file_type::not_found) return;
  read_truth_file(file, "left", recording);
  if (!recording.truth) return;
  if (recording.truth->size() != recording.frames.size()) {
    recording.truth_fault.emplace(fmt::format("{}: {} poses for {} images; give one pose per image",
                                              file.string(), recording.truth->size(),
                                              recording.frames.size()));
    log::warn("{}; the truth is not used", recording.truth_fault->what());
    recording.truth.reset();
    return;
  }
  for (const FramePair& frame : recording.frames) {
    recording.truth->stamps_s.push_back(to_seconds(frame.time_ns));
  }
}

}  // namespace

bool looks_like_kitti_odometry(const fs::path& folder) {
  return is_sequence(folder) || !sequences_of(folder).empty();
}

ImuNoise kitti_imu_noise() {
  ImuNoise noise;
  noise.gyro_noise_density = 2.0e-4;
  noise.gyro_random_walk = 2.0e-5;
  noise.accel_noise_density = 5.0e-3;
  noise.accel_random_walk = 1.0e-3;
  noise.rate_hz = 100.0;
  noise.gyro_range = 1.7;    // 100 deg/s
  noise.accel_range = 98.0;  // 10 g
  noise.gyro_bias_sigma = 5.0e-4;
  noise.accel_bias_sigma = 0.05;
  return noise;
}

Recording read_kitti_odometry(const fs::path& given) {
  const fs::path folder = sequence_folder(given);
  const auto [left, right] = camera_numbers(folder);
  const fs::path calib = folder / "calib.txt";
  KittiPair pair = kitti_pair(KittiCalibration(calib), "P" + left, "P" + right);
  const fs::path left_folder = folder / ("image_" + left);
  if (const auto size = common_image_size(left_folder, list_images(left_folder))) {
    pair.camera.width = size->width;  // the calibration does not state it
    pair.camera.height = size->height;
  }
  Recording recording("kitti_odometry", StereoRectifier(pair.camera));
  recording.name = folder_name(folder);
  recording.root = folder;
  recording.left_folder = left_folder;
  recording.right_folder = folder / ("image_" + right);
  recording.calibration_file = calib.string();
  recording.input_files = {calib, folder / "times.txt"};
  recording.frames = read_frames(folder, recording);
  read_imu(folder, recording);
  read_truth(folder, recording);
  return recording;
}

}  // namespace imslam::datasets

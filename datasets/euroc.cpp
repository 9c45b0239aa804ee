#include "datasets/euroc.hpp"

#include "datasets/calibration_yaml.hpp"
#include "datasets/imu_csv.hpp"
#include "datasets/trajectory_file.hpp"
#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;

fs::path mav0_of(const fs::path& folder) {
  return fs::is_directory(folder / "mav0") ? folder / "mav0" : folder;
}

/// Where TUM-VI keeps Kalibr's results; empty if this is plain EuRoC.
fs::path kalibr_file(const fs::path& mav0) {
  const fs::path file = mav0.parent_path() / "dso" / "camchain.yaml";
  return fs::exists(mav0 / "cam0" / "sensor.yaml") || !fs::exists(file) ? fs::path() : file;
}

struct Cameras {
  RawCamera cam0;
  RawCamera cam1;
  double timeshift_s = 0.0;
  std::vector<fs::path> files;
};

Cameras read_cameras(const fs::path& mav0) {
  Cameras cameras;
  const fs::path camchain = kalibr_file(mav0);
  if (!camchain.empty()) {
    KalibrChain chain = read_kalibr_chain(camchain);
    cameras.cam0 = chain.cam0;
    cameras.cam1 = chain.cam1;
    cameras.timeshift_s = chain.timeshift_s;
    cameras.files = {camchain};
    return cameras;
  }
  if (!fs::exists(mav0 / "cam1")) {
    throw InputError((mav0 / "cam1").string() +
                     ": missing: there is no right camera; stereo needs both, cam0 and cam1");
  }
  cameras.files = {mav0 / "cam0" / "sensor.yaml", mav0 / "cam1" / "sensor.yaml"};
  cameras.cam0 = read_euroc_camera(cameras.files[0]);
  cameras.cam1 = read_euroc_camera(cameras.files[1]);
  return cameras;
}

std::vector<ImageEntry> read_index(const fs::path& camera_folder, std::vector<fs::path>& files) {
  const fs::path csv = camera_folder / "data.csv";
  if (!fs::exists(csv)) {
    log::warn("{}: missing; the names of the images are taken as stamps", csv.string());
    return list_stamped_images(camera_folder / "data");
  }
  files.push_back(csv);
  std::vector<ImageEntry> images = clean_images(read_image_index(csv), csv.string());
  if (images.empty()) {
    throw InputError(
        csv.string() +
        ": names no image; write one line per image (stamp [ns], file name), or remove "
        "the file to take the images' names as stamps");
  }
  return images;
}

ImuNoise read_noise(const fs::path& mav0, std::vector<fs::path>& files) {
  const fs::path sensor = mav0 / "imu0" / "sensor.yaml";
  const fs::path kalibr = mav0.parent_path() / "dso" / "imu_config.yaml";
  for (const fs::path& file : {sensor, kalibr}) {
    if (!fs::exists(file)) continue;
    files.push_back(file);
    return read_kalibr_imu(file);
  }
  log::warn("{}: missing; noise of an ordinary MEMS sensor is assumed", sensor.string());
  return {};
}

std::optional<ImuData> read_imu(const fs::path& mav0,
                                double timeshift_s,
                                std::vector<fs::path>& files) {
  const fs::path csv = mav0 / "imu0" / "data.csv";
  if (!fs::exists(csv)) return std::nullopt;
  files.push_back(csv);
  ImuTable table = read_imu_csv(csv);
  if (table.samples.empty()) {
    throw InputError(csv.string() + ": no samples; remove the imu0 folder to run without IMU");
  }
  ImuData imu;
  imu.noise = read_noise(mav0, files);
  imu.samples = std::move(table.samples);
  imu.dropped = table.cleaning.dropped();
  // Kalibr: t_imu = t_camera + shift. Samples move to the cameras' clock.
  for (ImuSample& sample : imu.samples) sample.time_ns -= to_nanoseconds(timeshift_s);
  return imu;
}

lie::SE3d extrinsics_or_identity(const fs::path& sensor_yaml) {
  return fs::exists(sensor_yaml) ? read_euroc_extrinsics(sensor_yaml) : lie::SE3d();
}

void read_truth(const fs::path& mav0, const lie::SE3d& T_imu_body, Recording& recording) {
  for (const char* name : {"state_groundtruth_estimate0", "mocap0", "vicon0"}) {
    const fs::path csv = mav0 / name / "data.csv";
    if (!fs::exists(csv)) continue;
    read_truth_file(csv, "body", recording);
    const fs::path sensor = mav0 / name / "sensor.yaml";
    recording.T_body_truth = T_imu_body * extrinsics_or_identity(sensor);
    if (fs::exists(sensor)) recording.input_files.push_back(sensor);
    return;
  }
}

}  // namespace

bool looks_like_euroc(const fs::path& folder) {
  const fs::path mav0 = mav0_of(folder);
  return fs::is_directory(mav0 / "cam0" / "data") || fs::exists(mav0 / "cam0" / "data.csv");
}

Recording read_euroc(const fs::path& folder) {
  const fs::path mav0 = mav0_of(folder);
  Cameras cameras = read_cameras(mav0);
  std::vector<fs::path> files = cameras.files;
  std::vector<ImageEntry> left = read_index(mav0 / "cam0", files);
  std::vector<ImageEntry> right = read_index(mav0 / "cam1", files);
  const std::optional<ImuData> imu = read_imu(mav0, cameras.timeshift_s, files);

  lie::SE3d T_imu_body;
  if (imu && kalibr_file(mav0).empty()) {
    T_imu_body = extrinsics_or_identity(mav0 / "imu0" / "sensor.yaml").inverse();
  }
  for (RawCamera* camera : {&cameras.cam0, &cameras.cam1}) {
    camera->T_body_camera = T_imu_body * camera->T_body_camera;
  }
  const bool exchanged = stands_left_of(cameras.cam1, cameras.cam0);
  if (exchanged) {
    log::info("{}: cam1 stands to the left of cam0; it becomes the left camera", mav0.string());
    std::swap(cameras.cam0, cameras.cam1);
    std::swap(left, right);
  }
  const bool fisheye = cameras.cam0.lens == LensModel::kEquidistant;
  Recording recording(fisheye || fs::is_directory(mav0 / "mocap0") ? "tumvi" : "euroc",
                      StereoRectifier(cameras.cam0, cameras.cam1));
  recording.name = folder_name(mav0);
  recording.root = folder;
  recording.left_folder = mav0 / (exchanged ? "cam1" : "cam0") / "data";
  recording.right_folder = mav0 / (exchanged ? "cam0" : "cam1") / "data";
  recording.frames = pair_images(left, right, mav0.string());
  recording.imu = imu;
  recording.calibration_file = cameras.files.front().string();
  recording.input_files = std::move(files);
  read_truth(mav0, T_imu_body, recording);
  return recording;
}

}  // namespace imslam::datasets

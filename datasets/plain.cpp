#include "datasets/plain.hpp"

#include <algorithm>

#include "datasets/calibration_yaml.hpp"
#include "datasets/imu_csv.hpp"
#include "datasets/stamp_file.hpp"
#include "datasets/trajectory_file.hpp"
#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/base/time.hpp"

namespace imslam::datasets {
namespace {

namespace fs = std::filesystem;

struct PlainCalibration {
  StereoRectifier rectifier;
  ImuNoise noise;
  bool has_imu_extrinsics = false;
  double timeshift_s = 0.0;
  bool exchanged = false;  ///< the camera called right stands to the left
  std::vector<fs::path> files;
};

/// Rectifies, with the two in the order in which they stand.
StereoRectifier ordered_rectifier(const RawCamera& left, const RawCamera& right, bool& exchanged) {
  validate(left);
  validate(right);
  exchanged = stands_left_of(right, left);
  return exchanged ? StereoRectifier(right, left) : StereoRectifier(left, right);
}

/// The size and the intrinsics alone.
RawCamera read_pinhole(const YamlValue& map) {
  RawCamera camera;
  const auto size = map.at("size").numbers(2);
  const auto intrinsics = map.at("intrinsics").numbers(4);
  camera.where = map.at("intrinsics").where();
  camera.width = whole_pixels(map.at("size"), size[0]);
  camera.height = whole_pixels(map.at("size"), size[1]);
  camera.fx = intrinsics[0];
  camera.fy = intrinsics[1];
  camera.cx = intrinsics[2];
  camera.cy = intrinsics[3];
  return camera;
}

RawCamera read_raw_camera(const YamlValue& map) {
  RawCamera camera = read_pinhole(map);
  const YamlValue lens = map.at("distortion");
  camera.lens = lens_model(lens.text(), lens.where());
  if (camera.lens != LensModel::kNone) camera.distortion = map.at("coefficients").numbers();
  const YamlValue T = map.at("T_body_camera");
  camera.T_body_camera = rigid_motion(T.matrix4(), T.where());
  return camera;
}

StereoCamera read_rectified(const YamlValue& map) {
  const RawCamera camera = read_pinhole(map);
  validate(camera);
  StereoCamera pair;
  pair.width = camera.width;
  pair.height = camera.height;
  pair.fx = camera.fx;
  pair.fy = camera.fy;
  pair.cx = camera.cx;
  pair.cy = camera.cy;
  pair.baseline_m = map.at("baseline").number();
  if (!(pair.baseline_m > 1e-3 && pair.baseline_m < 10.0)) {
    map.at("baseline").fail("0.001 to 10 (metres, right camera to the right of the left one)");
  }
  if (map.has("T_body_left")) {
    const YamlValue T = map.at("T_body_left");
    pair.T_body_left = rigid_motion(T.matrix4(), T.where());
  }
  return pair;
}

PlainCalibration read_own(const fs::path& file) {
  const YamlValue root = load_yaml(file);
  const ImuNoise noise = root.has("imu") ? imu_noise(root.at("imu")) : ImuNoise();
  if (root.has("rectified")) {
    const YamlValue map = root.at("rectified");
    return {
        StereoRectifier(read_rectified(map)), noise, map.has("T_body_left"), 0.0, false, {file}};
  }
  bool exchanged = false;
  StereoRectifier rectifier = ordered_rectifier(read_raw_camera(root.at("left")),
                                                read_raw_camera(root.at("right")), exchanged);
  return {std::move(rectifier), noise, true, 0.0, exchanged, {file}};
}

PlainCalibration read_kalibr(const fs::path& camchain, const fs::path& imu_yaml) {
  const KalibrChain chain = read_kalibr_chain(camchain);
  bool exchanged = false;
  StereoRectifier rectifier = ordered_rectifier(chain.cam0, chain.cam1, exchanged);
  PlainCalibration calibration{std::move(rectifier), ImuNoise(), chain.has_imu,
                               chain.timeshift_s,    exchanged,  {camchain}};
  if (fs::exists(imu_yaml)) {
    calibration.noise = read_kalibr_imu(imu_yaml);
    calibration.files.push_back(imu_yaml);
  }
  return calibration;
}

PlainCalibration read_calibration(const fs::path& folder) {
  for (const char* name : {"camchain-imucam.yaml", "camchain.yaml"}) {
    if (fs::exists(folder / name)) return read_kalibr(folder / name, folder / "imu.yaml");
  }
  const fs::path own = folder / "calib.yaml";
  if (!fs::exists(own)) {
    throw InputError(own.string() +
                         ": missing; write one (left, right, imu) or copy Kalibr's "
                         "camchain-imucam.yaml here",
                     ExitCode::kCalibration);
  }
  // Kalibr's result under our name is fine, too.
  return load_yaml(own).has("cam0") ? read_kalibr(own, folder / "imu.yaml") : read_own(own);
}

std::vector<FramePair> frames_by_number(const fs::path& folder) {
  const auto times = read_times_file(folder / "times.txt");
  const auto left = names_by_frame(list_images(folder / "left"), times.size());
  const auto right = names_by_frame(list_images(folder / "right"), times.size());
  std::vector<FramePair> frames;
  for (std::size_t i = 0; i < times.size(); ++i) frames.push_back({times[i], left[i], right[i]});
  return frames;
}

std::vector<FramePair> read_frames(const fs::path& folder) {
  if (fs::exists(folder / "times.txt")) return frames_by_number(folder);
  return pair_images(list_stamped_images(folder / "left"), list_stamped_images(folder / "right"),
                     folder.string());
}

std::optional<ImuData> read_imu(const fs::path& csv, const PlainCalibration& calibration) {
  if (!fs::exists(csv)) return std::nullopt;
  if (!calibration.has_imu_extrinsics) {
    fail_calibration(calibration.files.front().string(),
                     "imu.csv is there, but not where the IMU sits: add T_body_left (calib.yaml) "
                     "or T_cam_imu (Kalibr), or remove imu.csv");
  }
  ImuTable table = read_imu_csv(csv);
  if (table.samples.empty()) {
    throw InputError(csv.string() + ": no samples; remove the file to run without IMU");
  }
  for (ImuSample& sample : table.samples) {
    sample.time_ns -= to_nanoseconds(calibration.timeshift_s);
  }
  return ImuData{calibration.noise, std::move(table.samples), table.cleaning.dropped()};
}

}  // namespace

bool looks_like_plain(const fs::path& folder) {
  return fs::is_directory(folder / "left") && fs::is_directory(folder / "right");
}

Recording read_plain(const fs::path& folder) {
  PlainCalibration calibration = read_calibration(folder);
  Recording recording("plain", std::move(calibration.rectifier));
  recording.name = folder_name(folder);
  recording.root = folder;
  recording.left_folder = folder / "left";
  recording.right_folder = folder / "right";
  recording.calibration_file = calibration.files.front().string();
  recording.input_files = calibration.files;
  recording.frames = read_frames(folder);
  recording.imu = read_imu(folder / "imu.csv", calibration);
  if (calibration.exchanged) {
    log::info("{}: the right camera stands to the left; the two change roles", folder.string());
    std::swap(recording.left_folder, recording.right_folder);
    for (FramePair& frame : recording.frames) std::swap(frame.left, frame.right);
  }
  std::error_code ignored;  // reading it says what is wrong with it
  if (fs::symlink_status(folder / "truth.tum", ignored).type() != fs::file_type::not_found) {
    read_truth_file(folder / "truth.tum", "body", recording);
  }
  for (const char* name : {"times.txt", "imu.csv"}) {
    if (fs::exists(folder / name)) recording.input_files.push_back(folder / name);
  }
  return recording;
}

}  // namespace imslam::datasets

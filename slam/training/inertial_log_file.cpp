#include "slam/training/inertial_log_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>

#include "datasets/calibration_yaml.hpp"
#include "datasets/imu_csv.hpp"
#include "datasets/kitti_calibration.hpp"
#include "datasets/kitti_odometry.hpp"
#include "datasets/recording.hpp"
#include "slam/base/error.hpp"
#include "slam/base/log.hpp"
#include "slam/training/truth_file.hpp"
#include "slam/training/truth_jumps.hpp"

namespace imslam::training {
namespace {

namespace fs = std::filesystem;

struct Raw {
  std::string name;
  fs::path imu_file;
  std::vector<ImuSample> samples;
  ImuNoise noise;
  TruthPath truth;
};

std::vector<ImuSample> read_samples(const fs::path& csv) {
  datasets::ImuTable table = datasets::read_imu_csv(csv);
  if (table.samples.size() < 2) {
    throw InputError(csv.string() + ": expected samples of an IMU, found " +
                     std::to_string(table.samples.size()) + "; record at least a few seconds");
  }
  return std::move(table.samples);
}

/// `stem`_suffix, e.g. PATH/NAME_imu.csv.
fs::path with_suffix(const fs::path& stem, const char* suffix) {
  return fs::path(stem.string() + suffix);
}

Raw read_euroc(const fs::path& folder) {
  const fs::path mav0 = fs::is_directory(folder / "mav0") ? folder / "mav0" : folder;
  Raw raw;
  raw.name = datasets::folder_name(folder);
  raw.imu_file = mav0 / "imu0" / "data.csv";
  raw.samples = read_samples(raw.imu_file);
  const fs::path sensor = mav0 / "imu0" / "sensor.yaml";
  lie::SE3d T_body_imu;
  if (fs::exists(sensor)) {
    raw.noise = datasets::read_kalibr_imu(sensor);
    T_body_imu = datasets::read_euroc_extrinsics(sensor);
  } else {
    log::warn("{}: missing; noise of an ADIS16448 is assumed", sensor.string());
  }
  raw.truth = read_euroc_truth(mav0, T_body_imu);
  return raw;
}

fs::path extrinsics_file(const fs::path& stem, const InertialLogFileOptions& options) {
  if (!options.T_cam0_imu.empty()) return options.T_cam0_imu;
  for (const fs::path& file :
       {with_suffix(stem, "_T_cam0_imu.txt"), stem.parent_path() / "T_cam0_imu.txt"}) {
    if (fs::exists(file)) return file;
  }
  throw InputError(
      with_suffix(stem, "_poses.txt").string() +
          ": poses of a camera need T_cam0_imu.txt (p_cam0 = T p_imu) beside them; put it there, "
          "or name it with --extrinsics",
      ExitCode::kCalibration);
}

Raw read_prefix(const fs::path& stem, const InertialLogFileOptions& options) {
  const fs::path tum = with_suffix(stem, "_truth.tum");
  const fs::path kitti = with_suffix(stem, "_poses.txt");
  Raw raw;
  raw.name = stem.filename().string();
  raw.imu_file = with_suffix(stem, "_imu.csv");
  raw.samples = read_samples(raw.imu_file);
  if (fs::exists(tum)) {
    raw.truth = read_tum_truth(tum);
  } else if (fs::exists(kitti)) {
    raw.noise = datasets::kitti_imu_noise();
    raw.truth = read_kitti_truth(kitti, raw.imu_file, with_suffix(stem, "_times.txt"),
                                 datasets::read_rigid_motion_file(extrinsics_file(stem, options)));
  } else {
    throw InputError(fmt::format("{}: has no truth beside it; expected {} (TUM) or {} (KITTI)",
                                 raw.imu_file.string(), tum.filename().string(),
                                 kitti.filename().string()));
  }
  const fs::path yaml = with_suffix(stem, "_imu.yaml");
  if (fs::exists(yaml)) raw.noise = datasets::read_kalibr_imu(yaml);
  return raw;
}

Raw read_raw(const fs::path& path, const InertialLogFileOptions& options) {
  for (const fs::path& imu0 : {path / "mav0" / "imu0", path / "imu0"}) {
    if (fs::exists(imu0 / "data.csv")) return read_euroc(path);
  }
  if (fs::exists(with_suffix(path, "_imu.csv"))) return read_prefix(path, options);
  throw InputError(fmt::format(
      "{}: no inertial log here; expected a EuRoC folder (mav0/imu0/data.csv), or PATH/NAME of "
      "{} with NAME_truth.tum or NAME_poses.txt",
      path.string(), with_suffix(path, "_imu.csv").string()));
}

/// Leaves out the poses before the first and after the last sample.
void cut_to_samples(Raw& raw) {
  const std::int64_t first_ns = raw.samples.front().time_ns;
  const std::int64_t last_ns = raw.samples.back().time_ns;
  TruthPath cut;
  for (std::size_t i = 0; i < raw.truth.path.size(); ++i) {
    const std::int64_t time_ns = raw.truth.path.times_ns[i];
    if (time_ns < first_ns || time_ns > last_ns) continue;
    cut.path.add(time_ns, raw.truth.path.poses[i]);
    if (!raw.truth.velocities.empty()) cut.velocities.push_back(raw.truth.velocities[i]);
  }
  if (cut.path.size() < 2) {
    const auto& times_ns = raw.truth.path.times_ns;
    throw InputError(fmt::format(
        "{}: samples from {} to {} ns, but the truth spans {} to {} ns; both must be on one clock",
        raw.imu_file.string(), first_ns, last_ns, times_ns.front(), times_ns.back()));
  }
  cut.path.frame = raw.truth.path.frame;
  raw.truth = std::move(cut);
}

VelocityFit velocities_of(const Raw& raw,
                          const std::vector<std::size_t>& jumps,
                          const GravityFit& gravity) {
  VelocityFit fit = fit_velocities(raw.samples, raw.noise, raw.truth.path, jumps, gravity);
  if (raw.truth.velocities.empty()) return fit;
  const double interval_s = 4.0 * fit.polynomial.half_width_s;
  const VelocityCheck check(raw.samples, raw.noise, raw.truth.path, gravity, interval_s);
  const auto& stated = raw.truth.velocities;
  fit.from_file = true;
  fit.sigma = check.sigma([&](std::size_t i) { return std::optional<Eigen::Vector3d>(stated[i]); });
  fit.known.assign(stated.size(), true);
  fit.velocities = stated;
  return fit;
}

}  // namespace

InertialLogReading read_inertial_log(const fs::path& path, const InertialLogFileOptions& options) {
  // "MH_01/" and "MH_01" are one log.
  fs::path given = path;
  if (given.filename().empty()) given = given.parent_path();
  Raw raw = read_raw(given, options);
  cut_to_samples(raw);
  InertialLogReading reading;
  const Trajectory& poses = raw.truth.path;
  reading.gravity = fit_gravity(raw.samples, raw.noise, poses);
  const auto jumps = find_jumps(raw.samples, raw.noise, poses, reading.gravity);
  reading.velocity = velocities_of(raw, jumps, reading.gravity);
  InertialLog& log = reading.log;
  log.name = raw.name;
  log.noise = raw.noise;
  log.gravity_world = reading.gravity.gravity_world;
  log.truth_sigma = options.truth;
  if (log.truth_sigma.velocity == 0.0) log.truth_sigma.velocity = reading.velocity.sigma;
  auto jump = jumps.begin();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!reading.velocity.known[i]) continue;
    if (jump != jumps.end() && *jump <= i) log.truth_jumps.push_back(log.truth.size());
    while (jump != jumps.end() && *jump <= i) ++jump;
    log.truth.push_back({poses.times_ns[i], {poses.poses[i], reading.velocity.velocities[i]}});
  }
  if (log.truth.size() < 2) {
    throw InputError(raw.imu_file.string() +
                     ": its truth is too short or too full of gaps to tell a velocity; expected at "
                     "least a second of poses");
  }
  log.samples = std::move(raw.samples);
  return reading;
}

}  // namespace imslam::training

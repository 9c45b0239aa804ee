#include "slam/training/truth_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "datasets/calibration_yaml.hpp"
#include "datasets/csv.hpp"
#include "datasets/stamp_file.hpp"
#include "datasets/trajectory_file.hpp"
#include "slam/base/error.hpp"
#include "slam/base/text.hpp"
#include "slam/base/time.hpp"

namespace imslam::training {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kIntervalTag = "nominal interval ";

void expect_increasing(const Trajectory& path, const fs::path& file) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (path.times_ns[i] > path.times_ns[i - 1]) continue;
    throw InputError(fmt::format(
        "{}: pose {} (stamp {} ns) is not later than the one before it; sort the file and remove "
        "repeated stamps",
        file.string(), i + 1, path.times_ns[i]));
  }
}

/// Poses with their stamps; `T_truth_body` carries from the IMU to what the file speaks of.
Trajectory stamped(const fs::path& file, const lie::SE3d& T_truth_body) {
  const PosePath poses = datasets::read_trajectory(file);
  if (!poses.has_stamps()) {
    throw InputError(file.string() +
                     ": expected poses with stamps (TUM or EuRoC), found KITTI's; name the file "
                     "NAME_poses.txt if they are of camera 0");
  }
  Trajectory path;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    path.add(static_cast<std::int64_t>(std::llround(poses.stamps_s[i] * kNanosecondsPerSecond)),
             lie::SE3d::from_matrix(poses.poses[i]) * T_truth_body);
  }
  expect_increasing(path, file);
  return path;
}

/// Whether the first row has columns for velocities.
bool states_velocities(const fs::path& csv) {
  datasets::LineReader lines(csv);
  while (lines.next()) {
    const std::string_view line = trim(lines.line());
    if (line.empty() || line.front() == '#') continue;
    return split(line, ',').size() >= 11;
  }
  return false;
}

std::vector<Eigen::Vector3d> read_velocities(const fs::path& csv) {
  using Kind = datasets::CsvColumn::Kind;
  std::vector<datasets::CsvColumn> columns = {{"time [ns]", Kind::kTime}};
  for (const char* name : {"p_x [m]", "p_y [m]", "p_z [m]", "q_w", "q_x", "q_y", "q_z", "v_x [m/s]",
                           "v_y [m/s]", "v_z [m/s]"}) {
    columns.push_back({name, Kind::kReal});
  }
  datasets::CsvReader reader(datasets::LineReader(csv), columns, true);
  std::vector<Eigen::Vector3d> velocities;
  while (reader.next()) velocities.emplace_back(reader.real(8), reader.real(9), reader.real(10));
  return velocities;
}

/// The number of seconds after kIntervalTag in a comment.
double nominal_interval(const fs::path& imu_csv) {
  datasets::LineReader lines(imu_csv);
  while (lines.next() && !lines.line().empty() && lines.line().front() == '#') {
    const std::size_t at = lines.line().find(kIntervalTag);
    if (at == std::string_view::npos) continue;
    const auto words = split_blanks(lines.line().substr(at + kIntervalTag.size()));
    const std::optional<double> interval = words.empty() ? std::nullopt : parse_double(words[0]);
    if (interval && *interval > 0.0 && *interval < 1e3) return *interval;
    throw InputError(
        fmt::format("{}: expected 'nominal interval X s' with X in seconds, as in "
                    "'nominal interval 0.1037 s'",
                    lines.where()));
  }
  throw InputError(imu_csv.string() +
                   ": the stamps of the poses are unknown; expected NAME_times.txt beside it, or a "
                   "comment '# nominal interval 0.1037 s' in its first lines");
}

/// x right, y down, z forward to x forward, y left, z up.
lie::SE3d upright_world() {
  Eigen::Matrix3d R;
  R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return {lie::SO3d::from_matrix(R), Eigen::Vector3d::Zero()};
}

}  // namespace

TruthPath read_tum_truth(const fs::path& file) { return {stamped(file, lie::SE3d()), {}}; }

TruthPath read_euroc_truth(const fs::path& mav0, const lie::SE3d& T_body_imu) {
  for (const char* name : {"state_groundtruth_estimate0", "mocap0", "vicon0"}) {
    const fs::path csv = mav0 / name / "data.csv";
    if (!fs::exists(csv)) continue;
    const fs::path sensor = mav0 / name / "sensor.yaml";
    lie::SE3d T_truth_imu = T_body_imu;
    if (fs::exists(sensor)) {
      T_truth_imu = datasets::read_euroc_extrinsics(sensor).inverse() * T_body_imu;
    }
    TruthPath truth;
    truth.path = stamped(csv, T_truth_imu);
    const bool at_imu = T_truth_imu.translation().norm() < 1e-6;
    if (at_imu && states_velocities(csv)) truth.velocities = read_velocities(csv);
    return truth;
  }
  throw InputError(mav0.string() +
                   ": no truth; expected state_groundtruth_estimate0/data.csv, mocap0 or vicon0");
}

TruthPath read_kitti_truth(const fs::path& poses_file,
                           const fs::path& imu_csv,
                           const fs::path& times_file,
                           const lie::SE3d& T_cam0_imu) {
  const PosePath poses = datasets::read_trajectory(poses_file);
  std::vector<std::int64_t> times_ns;
  if (fs::exists(times_file)) {
    times_ns = datasets::read_times_file(times_file);
    if (times_ns.size() != poses.size()) {
      throw InputError(fmt::format("{}: expected one stamp per pose, found {} for {} of {}",
                                   times_file.string(), times_ns.size(), poses.size(),
                                   poses_file.string()));
    }
  } else {
    const std::int64_t interval_ns = to_nanoseconds(nominal_interval(imu_csv));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      times_ns.push_back(static_cast<std::int64_t>(i) * interval_ns);
    }
  }
  TruthPath truth;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    truth.path.add(times_ns[i],
                   upright_world() * lie::SE3d::from_matrix(poses.poses[i]) * T_cam0_imu);
  }
  expect_increasing(truth.path, poses_file);
  return truth;
}

}  // namespace imslam::training

#include "datasets/kitti_calibration.hpp"

#include <fmt/format.h>

#include <cmath>

#include "datasets/camera_model.hpp"
#include "datasets/text_lines.hpp"
#include "slam/base/text.hpp"

namespace imslam::datasets {
namespace {

LineReader open_calibration(const std::filesystem::path& file) {
  try {
    return LineReader(file);
  } catch (const InputError& error) {
    throw InputError(error.what(), ExitCode::kCalibration);
  }
}

std::vector<double> finite_numbers(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view word : split_blanks(text)) {
    const auto number = parse_double(word);
    if (!number || !std::isfinite(*number)) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

KittiCalibration::KittiCalibration(const std::filesystem::path& file) : file_(file.string()) {
  LineReader lines = open_calibration(file);
  while (lines.next()) {
    const std::string_view line = trim(lines.line());
    const auto colon = line.find(':');
    if (colon == std::string_view::npos) continue;
    entries_[std::string(trim(line.substr(0, colon)))] = {lines.number(),
                                                          finite_numbers(line.substr(colon + 1))};
  }
}

std::string KittiCalibration::where(const std::string& name) const {
  const auto entry = entries_.find(name);
  return entry == entries_.end() ? file_ : fmt::format("{}:{}", file_, entry->second.line);
}

const std::vector<double>& KittiCalibration::numbers(const std::string& name,
                                                     std::size_t count) const {
  const auto entry = entries_.find(name);
  if (entry == entries_.end()) {
    fail_calibration(file_, fmt::format("expected a line '{}: ...' with {} numbers, there is none; "
                                        "take the file of the dataset",
                                        name, count));
  }
  if (entry->second.numbers.size() != count) {
    fail_calibration(where(name), fmt::format("expected {} numbers after '{}:', found {}; correct "
                                              "the line",
                                              count, name, entry->second.numbers.size()));
  }
  return entry->second.numbers;
}

Eigen::Matrix<double, 3, 4> KittiCalibration::matrix34(const std::string& name) const {
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers(name, 12).data());
}

Eigen::Matrix3d KittiCalibration::matrix33(const std::string& name) const {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers(name, 9).data());
}

Eigen::Vector2d KittiCalibration::vector2(const std::string& name) const {
  return Eigen::Map<const Eigen::Vector2d>(numbers(name, 2).data());
}

lie::SE3d KittiCalibration::rotation(const std::string& name) const {
  Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
  M.topLeftCorner<3, 3>() = matrix33(name);
  return rigid_motion(M, where(name));
}

lie::SE3d KittiCalibration::rigid(const std::string& rotation,
                                  const std::string& translation) const {
  Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
  M.topLeftCorner<3, 3>() = matrix33(rotation);
  M.topRightCorner<3, 1>() = Eigen::Map<const Eigen::Vector3d>(numbers(translation, 3).data());
  return rigid_motion(M, where(rotation));
}

lie::SE3d KittiCalibration::rigid34(const std::string& name) const {
  Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
  M.topRows<3>() = matrix34(name);
  return rigid_motion(M, where(name));
}

KittiPair kitti_pair(const KittiCalibration& calibration,
                     const std::string& left,
                     const std::string& right) {
  const auto P_left = calibration.matrix34(left);
  const auto P_right = calibration.matrix34(right);
  const std::string where = calibration.where(right);
  const Eigen::Matrix3d K = P_left.leftCols<3>();
  const bool pinhole = K(0, 0) > 0.0 && K(1, 1) > 0.0 && K(2, 2) == 1.0 && K(0, 1) == 0.0 &&
                       K.row(2).head<2>().isZero() && K(1, 0) == 0.0;
  if (!pinhole) {
    fail_calibration(calibration.where(left),
                     "expected a projection [fx 0 cx .; 0 fy cy .; 0 0 1 .] with fx, fy > 0");
  }
  if (!P_right.leftCols<3>().isApprox(K, 1e-9)) {
    fail_calibration(where, left + " and " + right +
                                " have different intrinsics; a rectified "
                                "pair has equal ones");
  }
  // P = K [I | t] with p_camera = p_cam0 + t
  const Eigen::Vector3d t_left = K.inverse() * P_left.col(3);
  const Eigen::Vector3d t_right = K.inverse() * P_right.col(3);
  KittiPair pair;
  StereoCamera& camera = pair.camera;
  camera.fx = K(0, 0);
  camera.fy = K(1, 1);
  camera.cx = K(0, 2);
  camera.cy = K(1, 2);
  camera.baseline_m = t_left.x() - t_right.x();
  if (!(camera.baseline_m > 1e-3 && camera.baseline_m < 10.0)) {
    fail_calibration(where, fmt::format("the right camera is {:.4g} m to the right of the left one,"
                                        " expected 0.001 to 10 m; {}",
                                        camera.baseline_m,
                                        camera.baseline_m < 0 ? "left and right are exchanged"
                                                              : "check the last column"));
  }
  pair.T_cam0_left = lie::SE3d(lie::SO3d(), -t_left);
  camera.T_body_left = pair.T_cam0_left;
  return pair;
}

lie::SE3d read_rigid_motion_file(const std::filesystem::path& file) {
  LineReader lines = open_calibration(file);
  std::vector<double> numbers;
  std::size_t first_line = 0;
  while (lines.next() && numbers.size() <= 16) {
    const std::string_view line = trim(lines.line());
    if (line.empty() || line.front() == '#') continue;
    const auto row = finite_numbers(line);
    if (row.empty()) fail_calibration(lines.where(), "expected finite numbers separated by blanks");
    if (first_line == 0) first_line = lines.number();
    numbers.insert(numbers.end(), row.begin(), row.end());
  }
  const std::string where = fmt::format("{}:{}", file.string(), first_line);
  if (numbers.size() != 12 && numbers.size() != 16) {
    fail_calibration(where,
                     fmt::format("expected a 3x4 or 4x4 matrix, found {} numbers", numbers.size()));
  }
  Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    M(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = numbers[i];
  }
  return rigid_motion(M, where);
}

}  // namespace imslam::datasets

#pragma once

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "slam/base/random.hpp"
#include "slam/base/time.hpp"
#include "slam/lie/se3.hpp"
#include "slam/sensors/calibration.hpp"
#include "slam/sensors/imu.hpp"

namespace imslam::testing {

/// A textured wall in front of a stereo-inertial rig that sways before it: small enough to be
/// written in a test, exact enough to check geometry on. World: z up; the wall is the plane x = 3
/// m.
struct TinyWorld {
  int width = 320;
  int height = 240;
  double f = 220.0;          ///< [px]
  double baseline_m = 0.12;  ///< [m]
  int frames = 20;
  double frame_rate = 20.0;  ///< [Hz]
  double imu_rate = 200.0;   ///< [Hz]
  std::int64_t start_ns = 1'000'000'000'000;
  double sway = 1.0;  ///< factor on the motion
  std::uint64_t seed = 1;

  /// Body x forward, y left, z up; camera x right, y down, z forward.
  lie::SE3d T_body_left() const {
    Eigen::Matrix3d R;
    R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return {lie::SO3d::from_matrix(R), Eigen::Vector3d(0.05, 0.5 * baseline_m, 0.02)};
  }
  lie::SE3d T_left_right() const { return {lie::SO3d(), Eigen::Vector3d(baseline_m, 0, 0)}; }

  StereoCamera camera() const {
    return {width, height, f, f, 0.5 * (width - 1), 0.5 * (height - 1), baseline_m, T_body_left()};
  }
  std::int64_t frame_time_ns(int i) const { return start_ns + to_nanoseconds(i / frame_rate); }

  lie::SE3d T_world_body(double t) const {
    const Eigen::Vector3d p(0.10 * std::sin(1.9 * t), 0.20 * std::sin(2.3 * t),
                            0.15 * std::sin(2.9 * t));
    const Eigen::Vector3d theta(0.20 * std::sin(2.1 * t), 0.15 * std::sin(2.7 * t),
                                0.20 * std::sin(1.7 * t));
    return {lie::SO3d::exp(sway * theta), sway * p};
  }

  /// Exact up to the central differences that it is made of.
  ImuSample imu_sample(double t) const {
    constexpr double kStep = 1e-4;
    const lie::SE3d before = T_world_body(t - kStep);
    const lie::SE3d now = T_world_body(t);
    const lie::SE3d after = T_world_body(t + kStep);
    const Eigen::Vector3d a_world =
        (before.translation() - 2.0 * now.translation() + after.translation()) / (kStep * kStep);
    ImuSample sample;
    sample.time_ns = start_ns + to_nanoseconds(t);
    sample.angular_velocity =
        (before.rotation().inverse() * after.rotation()).log() / (2.0 * kStep);
    sample.linear_acceleration =
        now.rotation().inverse() * Eigen::Vector3d(a_world + Eigen::Vector3d(0, 0, 9.81));
    return sample;
  }

  /// From 0.1 s before the first to 0.1 s after the last frame.
  std::vector<ImuSample> imu() const {
    std::vector<ImuSample> samples;
    const int count = static_cast<int>(((frames - 1) / frame_rate + 0.2) * imu_rate) + 1;
    for (int i = 0; i < count; ++i) samples.push_back(imu_sample(i / imu_rate - 0.1));
    return samples;
  }

  cv::Mat view(const lie::SE3d& T_world_camera) const;
  cv::Mat left(int i) const { return view(T_world_body(i / frame_rate) * T_body_left()); }
  cv::Mat right(int i) const {
    return view(T_world_body(i / frame_rate) * T_body_left() * T_left_right());
  }
};

/// Smooth random patches of several sizes.
inline cv::Mat tiny_texture(std::uint64_t seed) {
  constexpr int kSide = 1600;
  cv::Mat sum = cv::Mat::zeros(kSide, kSide, CV_32F);
  Random random(seed);
  for (const int cells : {400, 160, 50, 12}) {
    cv::Mat noise(cells, cells, CV_32F);
    for (int r = 0; r < cells; ++r) {
      for (int c = 0; c < cells; ++c) noise.at<float>(r, c) = static_cast<float>(random.normal());
    }
    cv::Mat large;
    cv::resize(noise, large, sum.size(), 0, 0, cv::INTER_CUBIC);
    sum += large;
  }
  cv::Mat texture;
  sum.convertTo(texture, CV_8U, 28.0, 128.0);
  return texture;
}

inline cv::Mat TinyWorld::view(const lie::SE3d& T_world_camera) const {
  static const cv::Mat texture = tiny_texture(1);
  constexpr double kWall_m = 3.0;
  constexpr double kPixelsPerMetre = 200.0;
  // Texture pixel (u, v) is the wall point (3, (c - u) / k, (c - v) / k).
  const double centre = 0.5 * texture.cols;
  Eigen::Matrix3d wall_from_texture;
  wall_from_texture << 0, 0, kWall_m, -1 / kPixelsPerMetre, 0, centre / kPixelsPerMetre, 0,
      -1 / kPixelsPerMetre, centre / kPixelsPerMetre;
  const StereoCamera pinhole = camera();
  Eigen::Matrix3d K;
  K << pinhole.fx, 0, pinhole.cx, 0, pinhole.fy, pinhole.cy, 0, 0, 1;
  const lie::SE3d T_camera_world = T_world_camera.inverse();
  // p_camera = R p_wall + t, with the homogeneous 1 of the texture pixel carrying t.
  Eigen::Matrix3d H = T_camera_world.rotation().matrix() * wall_from_texture;
  H.col(2) += T_camera_world.translation();
  H = K * H;
  const cv::Matx33d H_cv(H(0, 0), H(0, 1), H(0, 2), H(1, 0), H(1, 1), H(1, 2), H(2, 0), H(2, 1),
                         H(2, 2));
  cv::Mat image;
  cv::warpPerspective(texture, image, H_cv, cv::Size(width, height), cv::INTER_LINEAR,
                      cv::BORDER_REFLECT);
  return image;
}

inline void write_text(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

inline void write_image(const std::filesystem::path& file, const cv::Mat& image) {
  std::filesystem::create_directories(file.parent_path());
  cv::imwrite(file.string(), image);
}

template <typename... Values>
std::string format_line(const char* pattern, Values... values) {
  char line[512];
  std::snprintf(line, sizeof(line), pattern, values...);
  return line;
}

inline std::string imu_csv_text(const std::vector<ImuSample>& samples) {
  std::string text = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
  for (const ImuSample& s : samples) {
    const auto& w = s.angular_velocity;
    const auto& a = s.linear_acceleration;
    text +=
        format_line("%lld,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", static_cast<long long>(s.time_ns),
                    w.x(), w.y(), w.z(), a.x(), a.y(), a.z());
  }
  return text;
}

/// "a, b, ..." row by row.
inline std::string matrix_text(const Eigen::Matrix4d& M, const char* separator = ", ") {
  std::string text;
  for (int i = 0; i < 16; ++i) {
    text += (i == 0 ? "" : separator) + format_line("%.17g", M(i / 4, i % 4));
  }
  return text;
}

/// One camera's sensor.yaml; the images are free of distortion.
inline std::string euroc_camera_yaml(const TinyWorld& world, const lie::SE3d& T_body_camera) {
  const StereoCamera camera = world.camera();
  return "%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [" +
         matrix_text(T_body_camera.matrix()) + "]\nrate_hz: 20\n" +
         format_line(
             "resolution: [%d, %d]\ncamera_model: pinhole\n"
             "intrinsics: [%.17g, %.17g, %.17g, %.17g]\n",
             camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy) +
         "distortion_model: radial-tangential\n"
         "distortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n";
}

/// EuRoC layout with IMU and truth below `folder`/mav0.
inline void write_tiny_euroc(const std::filesystem::path& folder, const TinyWorld& world = {}) {
  const auto mav0 = folder / "mav0";
  std::string index = "#timestamp [ns],filename\n";
  std::string truth = "#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z\n";
  for (int i = 0; i < world.frames; ++i) {
    const auto time_ns = static_cast<long long>(world.frame_time_ns(i));
    const std::string name = std::to_string(time_ns) + ".png";
    index += std::to_string(time_ns) + "," + name + "\n";
    write_image(mav0 / "cam0" / "data" / name, world.left(i));
    write_image(mav0 / "cam1" / "data" / name, world.right(i));
    const lie::SE3d T = world.T_world_body(i / world.frame_rate);
    const auto& p = T.translation();
    const auto& q = T.rotation().quaternion();
    truth += format_line("%lld,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", time_ns, p.x(), p.y(),
                         p.z(), q.w(), q.x(), q.y(), q.z());
  }
  write_text(mav0 / "cam0" / "data.csv", index);
  write_text(mav0 / "cam1" / "data.csv", index);
  write_text(mav0 / "cam0" / "sensor.yaml", euroc_camera_yaml(world, world.T_body_left()));
  write_text(mav0 / "cam1" / "sensor.yaml",
             euroc_camera_yaml(world, world.T_body_left() * world.T_left_right()));
  write_text(mav0 / "imu0" / "data.csv", imu_csv_text(world.imu()));
  write_text(mav0 / "imu0" / "sensor.yaml",
             "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  data: [" +
                 matrix_text(Eigen::Matrix4d::Identity()) +
                 "]\nrate_hz: 200\ngyroscope_noise_density: 1.0e-4\n"
                 "gyroscope_random_walk: 1.0e-5\naccelerometer_noise_density: 1.0e-3\n"
                 "accelerometer_random_walk: 1.0e-4\n");
  write_text(mav0 / "state_groundtruth_estimate0" / "data.csv", truth);
}

/// KITTI odometry layout: `folder`/sequences/`number` with imu.csv, and the truth of camera 0.
/// Stamps start at 0. Returns the sequence's folder.
inline std::filesystem::path write_tiny_kitti(const std::filesystem::path& folder,
                                              TinyWorld world = {},
                                              const std::string& number = "00") {
  world.start_ns = 0;
  const auto sequence = folder / "sequences" / number;
  const StereoCamera camera = world.camera();
  std::string times;
  std::string poses;
  const lie::SE3d T_left0_world = (world.T_world_body(0) * world.T_body_left()).inverse();
  for (int i = 0; i < world.frames; ++i) {
    const std::string name = format_line("%06d.png", i);
    write_image(sequence / "image_0" / name, world.left(i));
    write_image(sequence / "image_1" / name, world.right(i));
    times += format_line("%.6e\n", to_seconds(world.frame_time_ns(i)));
    const Eigen::Matrix4d T =
        (T_left0_world * world.T_world_body(i / world.frame_rate) * world.T_body_left()).matrix();
    for (int k = 0; k < 12; ++k) {
      poses += format_line("%.17g%s", T(k / 4, k % 4), k == 11 ? "\n" : " ");
    }
  }
  const std::string P = format_line("%.17g 0 %.17g %%s 0 %.17g %.17g 0 0 0 1 0\n", camera.fx,
                                    camera.cx, camera.fy, camera.cy);
  const auto projection = [&P](const std::string& tx) {
    return std::string(P).replace(P.find("%s"), 2, tx);
  };
  write_text(sequence / "calib.txt",
             "P0: " + projection("0") +
                 "P1: " + projection(format_line("%.17g", -camera.fx * camera.baseline_m)) +
                 "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
  write_text(sequence / "times.txt", times);
  write_text(sequence / "imu.csv", imu_csv_text(world.imu()));
  write_text(sequence / "T_cam0_imu.txt",
             matrix_text(world.T_body_left().inverse().matrix(), " ") + "\n");
  write_text(folder / "poses" / (number + ".txt"), poses);
  return sequence;
}

}  // namespace imslam::testing

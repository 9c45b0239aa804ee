#include "datasets/simulation/sensor_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

namespace imslam::simulation {
namespace {

std::string extrinsics(const lie::SE3d& T_body_sensor) {
  const Eigen::Matrix4d T = T_body_sensor.matrix();
  std::string rows;
  for (int row = 0; row < 4; ++row) {
    rows += fmt::format("{}{}, {}, {}, {}", row == 0 ? "[" : ",\n         ", T(row, 0), T(row, 1),
                        T(row, 2), T(row, 3));
  }
  return fmt::format(
      "# Sensor extrinsics wrt. the body-frame.\n"
      "T_BS:\n  cols: 4\n  rows: 4\n  data: {}]\n\n",
      rows);
}

}  // namespace

std::string camera_file(const Lens& lens,
                        const lie::SE3d& T_body_camera,
                        double rate_hz,
                        const std::string& comment) {
  const Eigen::Vector4d& k = lens.intrinsics();
  return "# General sensor definitions.\nsensor_type: camera\n" +
         fmt::format("comment: simulated {} camera\n\n", comment) + extrinsics(T_body_camera) +
         "# Camera specific definitions.\n" +
         fmt::format("rate_hz: {}\nresolution: [{}, {}]\ncamera_model: pinhole\n", rate_hz,
                     lens.width(), lens.height()) +
         fmt::format("intrinsics: [{}, {}, {}, {}] #fu, fv, cu, cv\n", k[0], k[1], k[2], k[3]) +
         fmt::format("distortion_model: {}\n", distortion_name(lens.model())) +
         fmt::format("distortion_coefficients: [{}]\n", fmt::join(lens.coefficients(), ", "));
}

std::string imu_file(const ImuNoise& noise) {
  return "# General sensor definitions.\nsensor_type: imu\ncomment: simulated IMU\n\n" +
         extrinsics(lie::SE3d()) + fmt::format("rate_hz: {}\n\n", noise.rate_hz) +
         "# Noise densities in continuous time.\n" +
         fmt::format("gyroscope_noise_density: {}     # [ rad / s / sqrt(Hz) ]\n",
                     noise.gyro_noise_density) +
         fmt::format("gyroscope_random_walk: {}       # [ rad / s^2 / sqrt(Hz) ]\n",
                     noise.gyro_random_walk) +
         fmt::format("accelerometer_noise_density: {} # [ m / s^2 / sqrt(Hz) ]\n",
                     noise.accel_noise_density) +
         fmt::format("accelerometer_random_walk: {}   # [ m / s^3 / sqrt(Hz) ]\n\n",
                     noise.accel_random_walk) +
         fmt::format(
             "gyroscope_range: {}     # [ rad / s ]\naccelerometer_range: {} # [ m / s^2 ]\n",
             noise.gyro_range, noise.accel_range);
}

std::string truth_file() {
  return "# General sensor definitions.\nsensor_type: visual-inertial\n"
         "comment: exact pose, velocity and IMU bias of the simulation\n\n" +
         extrinsics(lie::SE3d());
}

}  // namespace imslam::simulation
